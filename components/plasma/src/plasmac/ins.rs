//! The pins that `plasmac` reads.

use hal_component::{In, pins};

pins! {
    /// The arc: its voltage, and how it is lit.
    pub(super) struct Arc {
        /// Seconds to wait for an arc before a start has failed.
        fail_delay: In<f64> = "arc-fail-delay", 0.0;
        /// Seconds that an arc may be away during a cut before it is lost.
        lost_delay: In<f64> = "arc-lost-delay", 0.0;
        /// How often a start is tried.
        max_starts: In<i32> = "arc-max-starts", 0;
        /// Highest voltage of an arc that is there, in volts, with `mode` 0.
        ok_high: In<f64> = "arc-ok-high", 0.0;
        /// Lowest voltage of an arc that is there, in volts, with `mode` 0.
        ok_low: In<f64> = "arc-ok-low", 0.0;
        /// The power source says that there is an arc, with `mode` 1 and 2.
        ok_in: In<bool> = "arc-ok-in", false;
        /// The voltage as it is measured, in units of its own that the scale makes volts; its sign does not count.
        voltage_in: In<f64> = "arc-voltage-in", 0.0;
        /// What is measured at 0 volts.
        voltage_offset: In<f64> = "arc-voltage-offset", 0.0;
        /// Volts for one of what is measured, less the offset.
        voltage_scale: In<f64> = "arc-voltage-scale", 0.0;
        /// With `mode` 0, for how many runs the voltage must be steady before there is an arc.
        ok_sample_counts: In<i32> = "ok-sample-counts", 10;
        /// By how many volts it may differ meanwhile.
        ok_sample_threshold: In<f64> = "ok-sample-threshold", 10.0;
        /// Cuts though nothing says that there is an arc: as the program wants.
        ignore_ok_0: In<bool> = "ignore-arc-ok-0", false;
        /// Cuts though nothing says that there is an arc: as the user wants.
        ignore_ok_1: In<bool> = "ignore-arc-ok-1", false;
        /// Seconds before a start is tried again.
        restart_delay: In<f64> = "restart-delay", 0.0;
        /// Frequency of the low-pass filter of `arc-voltage-out`, in hertz; 0: none.
        lowpass_frequency: In<f64> = "lowpass-frequency", 0.0;
        /// Volts to each side of 0 that are shown as 0.
        zero_window: In<f64> = "zero-window", 0.1;
    }
}

pins! {
    /// The machine: where it is, and what it does.
    pub(super) struct Machine {
        /// The machine is on.
        is_on: In<bool> = "machine-is-on", false;
        /// All joints are homed.
        homed: In<bool> = "homed", false;
        /// An emergency stop of the outside.
        external_estop: In<bool> = "external-estop", false;
        /// Machine units per millimetre, from `halui.machine.units-per-mm`.
        units_per_mm: In<f64> = "units-per-mm", 0.0;
        /// X, from `axis.x.pos-cmd`, in machine units.
        x: In<f64> = "axis-x-position", 0.0;
        /// Lowest X of an offset probe, in machine units.
        x_min: In<f64> = "axis-x-min-limit", 0.0;
        /// Highest X of an offset probe, in machine units.
        x_max: In<f64> = "axis-x-max-limit", 0.0;
        /// Y, from `axis.y.pos-cmd`, in machine units.
        y: In<f64> = "axis-y-position", 0.0;
        /// Lowest Y of an offset probe, in machine units.
        y_min: In<f64> = "axis-y-min-limit", 0.0;
        /// Highest Y of an offset probe, in machine units.
        y_max: In<f64> = "axis-y-max-limit", 0.0;
        /// Z, from the joint's `pos-fb`, in machine units.
        z: In<f64> = "axis-z-position", 0.0;
        /// Lowest Z, in machine units.
        z_min: In<f64> = "axis-z-min-limit", 0.0;
        /// Highest Z, in machine units.
        z_max: In<f64> = "axis-z-max-limit", 0.0;
        /// The offset of X that is there, in machine units, from `axis.x.eoffset`.
        x_offset_current: In<f64> = "x-offset-current", 0.0;
        /// The offset of Y that is there, in machine units, from `axis.y.eoffset`.
        y_offset_current: In<f64> = "y-offset-current", 0.0;
        /// The offset of Z that is there, in machine units, from `axis.z.eoffset`.
        z_offset_current: In<f64> = "z-offset-current", 0.0;
        /// Offsets are there, from `motion.eoffset-active`.
        offsets_active: In<bool> = "offsets-active", false;
        /// Speed of the tool, from `motion.current-vel`, in machine units per second.
        velocity: In<f64> = "current-velocity", 0.0;
        /// The speed that is wanted, in machine units per second; not used.
        requested_velocity: In<f64> = "requested-velocity", 0.0;
        /// The kind of move, from `motion.motion-type`: 1 is a rapid one.
        motion_type: In<i32> = "motion-type", 0;
        /// The program's feed rate, from `motion.feed-upm`, in its units per minute.
        feed_upm: In<f64> = "feed-upm", 0.0;
        /// Machine units for one of the program's.
        gcode_scale: In<f64> = "gcode-scale", 1.0;
        /// Feed override, where 1 is 100 percent; not used here.
        feed_override: In<f64> = "feed-override", 0.0;
        /// To how many percent the program reduces the feed, 10 to 100; else it does not.
        feed_reduction: In<f64> = "feed-reduction", 0.0;
        /// No program runs.
        is_idle: In<bool> = "program-is-idle", false;
        /// A program is paused.
        is_paused: In<bool> = "program-is-paused", false;
        /// A program runs.
        is_running: In<bool> = "program-is-running", false;
    }
}

pins! {
    /// Probing for the surface.
    pub(super) struct Probe {
        /// Speed downwards, in machine units per minute.
        feed_rate: In<f64> = "probe-feed-rate", 0.0;
        /// Speed of the last part of probing, in counts of the Z offset per run.
        final_speed: In<i32> = "probe-final-speed", 1;
        /// Height above the lowest Z down to which it moves at the setup speed, in machine units.
        start_height: In<f64> = "probe-start-height", 0.0;
        /// Probes and stays down for a while, and does not cut.
        test: In<bool> = "probe-test", false;
        /// The float switch: the torch stands on the surface.
        float_switch: In<bool> = "float-switch", false;
        /// How far the torch gives way until the float switch closes, in machine units.
        float_switch_travel: In<f64> = "float-switch-travel", 0.0;
        /// The torch broke away.
        breakaway: In<bool> = "breakaway", false;
        /// Contact of the tip, after `ohmic-sense-out` or of another component.
        ohmic_probe: In<bool> = "ohmic-probe", false;
        /// Probes by contact of the tip.
        ohmic_probe_enable: In<bool> = "ohmic-probe-enable", false;
        /// Height of the surface above where contact is told, in machine units.
        ohmic_probe_offset: In<f64> = "ohmic-probe-offset", 0.0;
        /// How often contact is tried before the float switch alone counts.
        ohmic_max_attempts: In<i32> = "ohmic-max-attempts", 0;
        /// Tests whether the torch is shorted.
        ohmic_test: In<bool> = "ohmic-test", false;
        /// The relay of the contact.
        ohmic_sense_in: In<bool> = "ohmic-sense-in", false;
        /// For how many runs the relay must be on.
        ohmic_sense_on_delay: In<i32> = "ohmic-sense-on-delay", 3;
        /// For how many runs the relay must be off.
        ohmic_sense_off_delay: In<i32> = "ohmic-sense-off-delay", 3;
        /// No probing within this distance of the last cut, in machine units.
        skip_ihs_distance: In<f64> = "skip-ihs-distance", 0.0;
        /// Sets `ohmic-enable` while nothing is done, to see where an offset probe is.
        offset_set_probe: In<bool> = "offset-set-probe", false;
        /// Moves a scribe out.
        offset_set_scribe: In<bool> = "offset-set-scribe", false;
        /// Seconds until an offset probe is out, and until it is back.
        offset_delay: In<f64> = "offset-probe-delay", 0.0;
        /// Distance of an offset probe in X, with `ohmic-probe-enable`, in machine units.
        offset_x: In<f64> = "offset-probe-x", 0.0;
        /// Distance of an offset probe in Y, with `ohmic-probe-enable`, in machine units.
        offset_y: In<f64> = "offset-probe-y", 0.0;
    }
}

//! Input pins of `plasmac`: arc, machine and probing.

use hal_component::{In, pins};

pins! {
    /// Arc voltage, and the settings for starting the arc.
    pub(super) struct Arc {
        /// Seconds to wait for an arc before a start counts as failed.
        fail_delay: In<f64> = "arc-fail-delay", 0.0;
        /// Seconds that the arc may be missing during a cut before it counts as lost.
        lost_delay: In<f64> = "arc-lost-delay", 0.0;
        /// Number of attempts to start the arc.
        max_starts: In<i32> = "arc-max-starts", 0;
        /// Highest arc voltage that counts as an arc, in volts, with `mode` 0.
        ok_high: In<f64> = "arc-ok-high", 0.0;
        /// Lowest arc voltage that counts as an arc, in volts, with `mode` 0.
        ok_low: In<f64> = "arc-ok-low", 0.0;
        /// Arc OK signal of the power source, with `mode` 1 and 2.
        ok_in: In<bool> = "arc-ok-in", false;
        /// Measured arc voltage in raw units; `arc-voltage-scale` converts it to volts. Its sign is ignored.
        voltage_in: In<f64> = "arc-voltage-in", 0.0;
        /// Value of `arc-voltage-in` at 0 volts.
        voltage_offset: In<f64> = "arc-voltage-offset", 0.0;
        /// Volts per raw unit, after `arc-voltage-offset` is subtracted. Its sign is ignored.
        voltage_scale: In<f64> = "arc-voltage-scale", 0.0;
        /// With `mode` 0, number of cycles for which the voltage must be steady before the arc is OK.
        ok_sample_counts: In<i32> = "ok-sample-counts", 10;
        /// Largest difference between consecutive cycles that counts as steady, in volts.
        ok_sample_threshold: In<f64> = "ok-sample-threshold", 10.0;
        /// Ignores a missing arc, at the program's request: cuts although there is no arc OK.
        ignore_ok_0: In<bool> = "ignore-arc-ok-0", false;
        /// Ignores a missing arc, at the user's request: cuts although there is no arc OK.
        ignore_ok_1: In<bool> = "ignore-arc-ok-1", false;
        /// Seconds before another attempt to start the arc.
        restart_delay: In<f64> = "restart-delay", 0.0;
        /// Cutoff frequency of the low-pass filter of `arc-voltage-out`, in hertz; 0: no filter.
        lowpass_frequency: In<f64> = "lowpass-frequency", 0.0;
        /// Voltages closer to 0 than this, in volts, are shown as 0.
        zero_window: In<f64> = "zero-window", 0.1;
    }
}

pins! {
    /// State and position of the machine.
    pub(super) struct MachinePins {
        /// TRUE while the machine is on.
        is_on: In<bool> = "machine-is-on", false;
        /// TRUE while all joints are homed.
        homed: In<bool> = "homed", false;
        /// External emergency stop.
        external_estop: In<bool> = "external-estop", false;
        /// Machine units per millimetre, from `halui.machine.units-per-mm`.
        units_per_mm: In<f64> = "units-per-mm", 0.0;
        /// Commanded X position, from `axis.x.pos-cmd`, in machine units.
        x: In<f64> = "axis-x-position", 0.0;
        /// Lower limit of X for an offset probe, in machine units.
        x_min: In<f64> = "axis-x-min-limit", 0.0;
        /// Upper limit of X for an offset probe, in machine units.
        x_max: In<f64> = "axis-x-max-limit", 0.0;
        /// Commanded Y position, from `axis.y.pos-cmd`, in machine units.
        y: In<f64> = "axis-y-position", 0.0;
        /// Lower limit of Y for an offset probe, in machine units.
        y_min: In<f64> = "axis-y-min-limit", 0.0;
        /// Upper limit of Y for an offset probe, in machine units.
        y_max: In<f64> = "axis-y-max-limit", 0.0;
        /// Z position feedback, from the joint's `pos-fb`, in machine units.
        z: In<f64> = "axis-z-position", 0.0;
        /// Lower limit of Z, in machine units.
        z_min: In<f64> = "axis-z-min-limit", 0.0;
        /// Upper limit of Z, in machine units.
        z_max: In<f64> = "axis-z-max-limit", 0.0;
        /// Present external offset of X, in machine units, from `axis.x.eoffset`.
        x_offset_current: In<f64> = "x-offset-current", 0.0;
        /// Present external offset of Y, in machine units, from `axis.y.eoffset`.
        y_offset_current: In<f64> = "y-offset-current", 0.0;
        /// Present external offset of Z, in machine units, from `axis.z.eoffset`.
        z_offset_current: In<f64> = "z-offset-current", 0.0;
        /// TRUE while external offsets are applied, from `motion.eoffset-active`.
        offsets_active: In<bool> = "offsets-active", false;
        /// Speed of the tool, from `motion.current-vel`, in machine units per second.
        velocity: In<f64> = "current-velocity", 0.0;
        /// Requested speed, in machine units per second; not used.
        requested_velocity: In<f64> = "requested-velocity", 0.0;
        /// Type of the present move, from `motion.motion-type`: 1 is a rapid move.
        motion_type: In<i32> = "motion-type", 0;
        /// Feed rate of the program, from `motion.feed-upm`, in program units per minute.
        feed_upm: In<f64> = "feed-upm", 0.0;
        /// Machine units per program unit.
        gcode_scale: In<f64> = "gcode-scale", 1.0;
        /// Feed override, where 1 is 100 percent; not used here.
        feed_override: In<f64> = "feed-override", 0.0;
        /// Feed of the program in percent, for reduced feed: from 10 to below 100; other values reduce nothing.
        feed_reduction: In<f64> = "feed-reduction", 0.0;
        /// TRUE while no program runs.
        is_idle: In<bool> = "program-is-idle", false;
        /// TRUE while a program is paused.
        is_paused: In<bool> = "program-is-paused", false;
        /// TRUE while a program runs.
        is_running: In<bool> = "program-is-running", false;
    }
}

pins! {
    /// Probing for the surface.
    pub(super) struct Probe {
        /// Speed of probing downwards, in machine units per minute.
        feed_rate: In<f64> = "probe-feed-rate", 0.0;
        /// Speed of the last phase of probing, in counts of the Z offset per cycle.
        final_speed: In<i32> = "probe-final-speed", 1;
        /// Height above the lower limit of Z down to which Z moves at the setup speed, in machine units.
        start_height: In<f64> = "probe-start-height", 0.0;
        /// Starts a probe test: probes, holds for a while and does not cut.
        test: In<bool> = "probe-test", false;
        /// Float switch: closed while the torch rests on the surface.
        float_switch: In<bool> = "float-switch", false;
        /// Travel of the torch holder until the float switch closes, in machine units.
        float_switch_travel: In<f64> = "float-switch-travel", 0.0;
        /// Breakaway switch: the torch broke away.
        breakaway: In<bool> = "breakaway", false;
        /// Contact of the tip, from `ohmic-sense-out` or from another component.
        ohmic_probe: In<bool> = "ohmic-probe", false;
        /// Enables probing by contact of the tip (ohmic probing).
        ohmic_probe_enable: In<bool> = "ohmic-probe-enable", false;
        /// Height of the surface above the Z where the tip reports contact, in machine units.
        ohmic_probe_offset: In<f64> = "ohmic-probe-offset", 0.0;
        /// Number of ohmic probe attempts before the float switch alone counts.
        ohmic_max_attempts: In<i32> = "ohmic-max-attempts", 0;
        /// Tests whether the torch is shorted.
        ohmic_test: In<bool> = "ohmic-test", false;
        /// Contact relay of the ohmic probe.
        ohmic_sense_in: In<bool> = "ohmic-sense-in", false;
        /// Number of cycles for which `ohmic-sense-in` must be on before `ohmic-sense-out` turns on.
        ohmic_sense_on_delay: In<i32> = "ohmic-sense-on-delay", 3;
        /// Number of cycles for which `ohmic-sense-in` must be off before `ohmic-sense-out` turns off.
        ohmic_sense_off_delay: In<i32> = "ohmic-sense-off-delay", 3;
        /// Distance to the last cut below which no probing takes place, in machine units.
        skip_ihs_distance: In<f64> = "skip-ihs-distance", 0.0;
        /// Sets `ohmic-enable` while idle, to find the position of an offset probe.
        offset_set_probe: In<bool> = "offset-set-probe", false;
        /// Extends the scribe arm while idle.
        offset_set_scribe: In<bool> = "offset-set-scribe", false;
        /// Seconds that an offset probe needs to extend, and to retract.
        offset_delay: In<f64> = "offset-probe-delay", 0.0;
        /// Offset of the probe from the torch in X, with `ohmic-probe-enable`, in machine units.
        offset_x: In<f64> = "offset-probe-x", 0.0;
        /// Offset of the probe from the torch in Y, with `ohmic-probe-enable`, in machine units.
        offset_y: In<f64> = "offset-probe-y", 0.0;
    }
}

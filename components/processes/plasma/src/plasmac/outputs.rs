//! Output pins of `plasmac`: commands to the machine, and status.

use hal_component::{Out, pins};

pins! {
    /// Commands to the machine: torch, offsets and program.
    pub(super) struct Drive {
        /// Feed factor without unit, for `motion.adaptive-feed`.
        adaptive_feed: Out<f64> = "adaptive-feed", 0.0;
        /// Feed hold, for `motion.feed-hold`.
        feed_hold: Out<bool> = "feed-hold", false;
        /// Inhibits jogging, for `motion.jog-inhibit`.
        jog_inhibit: Out<bool> = "jog-inhibit", false;
        /// Machine units per count, for `axis.L.eoffset-scale`.
        offset_scale: Out<f64> = "offset-scale", 0.0;
        /// X offset in counts, for `axis.x.eoffset-counts`.
        x_counts: Out<i32> = "x-offset-counts", 0;
        /// Y offset in counts, for `axis.y.eoffset-counts`.
        y_counts: Out<i32> = "y-offset-counts", 0;
        /// Z offset in counts, for `axis.z.eoffset-counts`.
        z_counts: Out<i32> = "z-offset-counts", 0;
        /// Enables the X and Y offsets, for `axis.L.eoffset-enable`.
        xy_enable: Out<bool> = "xy-offset-enable", false;
        /// Enables the Z offset, for `axis.z.eoffset-enable`.
        z_enable: Out<bool> = "z-offset-enable", false;
        /// Turns the torch on.
        torch_on: Out<bool> = "torch-on", false;
        /// Extends the scribe arm.
        scribe_arm: Out<bool> = "scribe-arm", false;
        /// Turns the scribe on.
        scribe_on: Out<bool> = "scribe-on", false;
        /// True while probing by contact of the tip.
        ohmic_enable: Out<bool> = "ohmic-enable", false;
        /// `ohmic-sense-in`, debounced.
        ohmic_sense_out: Out<bool> = "ohmic-sense-out", false;
        /// Pauses the program, for `halui.program.pause`.
        program_pause: Out<bool> = "program-pause", false;
        /// Resumes the program, for `halui.program.resume`.
        program_resume: Out<bool> = "program-resume", false;
        /// Runs the program, for `halui.program.run`.
        program_run: Out<bool> = "program-run", false;
        /// Stops the program, for `halui.program.stop`.
        program_stop: Out<bool> = "program-stop", false;
        /// Ends a manual cut, for `halui.spindle.0.stop`.
        cutting_stop: Out<bool> = "cutting-stop", false;
    }
}

pins! {
    /// Status for the operator.
    pub(super) struct Status {
        /// True while there is an arc (arc OK).
        arc_ok: Out<bool> = "arc-ok-out", false;
        /// Arc voltage in volts, rounded to three decimals.
        arc_voltage: Out<f64> = "arc-voltage-out", 0.0;
        /// True while consumables are changed.
        consumable_changing: Out<bool> = "consumable-changing", false;
        /// True while height control is suspended for a corner, or has not started yet.
        cornerlock: Out<bool> = "cornerlock-is-locked", false;
        /// True while height control is suspended over a void.
        voidlock: Out<bool> = "voidlock-is-locked", false;
        /// Length of the cuts of this job, in machine units.
        cut_length: Out<f64> = "cut-length", 0.0;
        /// Time of cutting in this job, in seconds.
        cut_time: Out<f64> = "cut-time", 0.0;
        /// Time of pauses in this job, in seconds.
        paused_time: Out<f64> = "paused-time", 0.0;
        /// Time of probing in this job, in seconds.
        probe_time: Out<f64> = "probe-time", 0.0;
        /// Time of rapid moves in this job, in seconds.
        rapid_time: Out<f64> = "rapid-time", 0.0;
        /// Total time of this job, in seconds.
        run_time: Out<f64> = "run-time", 0.0;
        /// Time with the torch on in this job, in seconds.
        torch_time: Out<f64> = "torch-time", 0.0;
        /// Number of torch starts in this job.
        pierce_count: Out<i32> = "pierce-count", 0;
        /// True while a cut is recovered.
        cut_recovering: Out<bool> = "cut-recovering", false;
        /// Progress of laser recovery: 0 to 5.
        laser_recovery_state: Out<i32> = "laser-recovery-state", 0;
        /// True while height control moves Z down.
        led_down: Out<bool> = "led-down", false;
        /// True while height control moves Z up.
        led_up: Out<bool> = "led-up", false;
        /// True while the machine moves along the path of a paused program.
        paused_motion: Out<bool> = "paused-motion", false;
        /// True if Z reached its lower limit in a probe test.
        probe_test_error: Out<bool> = "probe-test-error", false;
        /// True if the safe height had to be lower than requested.
        safe_height_limited: Out<bool> = "safe-height-is-limited", false;
        /// True while the float switch, the breakaway switch or the ohmic contact is active.
        sensor_active: Out<bool> = "sensor-active", false;
        /// Number of the present state.
        state: Out<i32> = "state-out", 0;
        /// Reason for the end of a cut: 0 none, 1 the program, 2 the end of a cut, 3 a pause or a fault.
        stop_type: Out<i32> = "stop-type-out", 0;
        /// True while height control is working.
        thc_active: Out<bool> = "thc-active", false;
        /// True while height control is allowed.
        thc_enabled: Out<bool> = "thc-enabled", false;
        /// Target voltage of height control, in volts.
        target_volts: Out<f64> = "target-volts", 0.0;
        /// Height above the surface, or above the lower limit of Z before a surface is known, in machine units.
        z_height: Out<f64> = "z-height", 0.0;
        /// Distance from the last surface, in machine units: always 0, as observed in LinuxCNC.
        z_relative: Out<f64> = "z-relative", 0.0;
        /// Present feed rate, in machine units per minute.
        current_feed_rate: Out<f64> = "current-feed-rate", 0.0;
        /// Feed rate that the program requests, in program units per minute.
        requested_feed_rate: Out<f64> = "requested-feed-rate", 0.0;
    }
}

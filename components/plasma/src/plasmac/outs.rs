//! The pins that `plasmac` drives.

use hal_component::{Out, pins};

pins! {
    /// The machine: torch, offsets, the program.
    pub(super) struct Drive {
        /// Factor of the feed, without a unit, for `motion.adaptive-feed`.
        adaptive_feed: Out<f64> = "adaptive-feed", 0.0;
        /// Holds the feed, for `motion.feed-hold`.
        feed_hold: Out<bool> = "feed-hold", false;
        /// Jogging is not allowed, for `motion.jog-inhibit`.
        jog_inhibit: Out<bool> = "jog-inhibit", false;
        /// Units of one count, for `axis.L.eoffset-scale`.
        offset_scale: Out<f64> = "offset-scale", 0.0;
        /// Offset of X, for `axis.x.eoffset-counts`.
        x_counts: Out<i32> = "x-offset-counts", 0;
        /// Offset of Y, for `axis.y.eoffset-counts`.
        y_counts: Out<i32> = "y-offset-counts", 0;
        /// Offset of Z, for `axis.z.eoffset-counts`.
        z_counts: Out<i32> = "z-offset-counts", 0;
        /// Offsets of X and Y count, for `axis.L.eoffset-enable`.
        xy_enable: Out<bool> = "xy-offset-enable", false;
        /// The offset of Z counts, for `axis.z.eoffset-enable`.
        z_enable: Out<bool> = "z-offset-enable", false;
        /// Lights the torch.
        torch_on: Out<bool> = "torch-on", false;
        /// The scribe's arm is out.
        scribe_arm: Out<bool> = "scribe-arm", false;
        /// The scribe is on.
        scribe_on: Out<bool> = "scribe-on", false;
        /// Probes by contact now.
        ohmic_enable: Out<bool> = "ohmic-enable", false;
        /// `ohmic-sense-in`, debounced.
        ohmic_sense_out: Out<bool> = "ohmic-sense-out", false;
        /// Pauses the program, for `halui.program.pause`.
        program_pause: Out<bool> = "program-pause", false;
        /// Lets it go on, for `halui.program.resume`.
        program_resume: Out<bool> = "program-resume", false;
        /// Runs it, for `halui.program.run`.
        program_run: Out<bool> = "program-run", false;
        /// Stops it, for `halui.program.stop`.
        program_stop: Out<bool> = "program-stop", false;
        /// Ends a cut by hand, for `halui.spindle.0.stop`.
        cutting_stop: Out<bool> = "cutting-stop", false;
    }
}

pins! {
    /// What there is to be told.
    pub(super) struct Told {
        /// There is an arc.
        arc_ok: Out<bool> = "arc-ok-out", false;
        /// The arc's voltage, in volts to three decimals.
        arc_voltage: Out<f64> = "arc-voltage-out", 0.0;
        /// Consumables are being changed.
        consumable_changing: Out<bool> = "consumable-changing", false;
        /// Height control stopped for a corner, or has not begun.
        cornerlock: Out<bool> = "cornerlock-is-locked", false;
        /// Height control stopped over a void.
        voidlock: Out<bool> = "voidlock-is-locked", false;
        /// Way that was cut in this job, in machine units.
        cut_length: Out<f64> = "cut-length", 0.0;
        /// Seconds of cutting in this job.
        cut_time: Out<f64> = "cut-time", 0.0;
        /// Seconds of pause in this job.
        paused_time: Out<f64> = "paused-time", 0.0;
        /// Seconds of probing in this job.
        probe_time: Out<f64> = "probe-time", 0.0;
        /// Seconds of rapid moves in this job.
        rapid_time: Out<f64> = "rapid-time", 0.0;
        /// Seconds of this job.
        run_time: Out<f64> = "run-time", 0.0;
        /// Seconds of the torch in this job.
        torch_time: Out<f64> = "torch-time", 0.0;
        /// Starts of the torch in this job.
        pierce_count: Out<i32> = "pierce-count", 0;
        /// A cut is being taken up again.
        cut_recovering: Out<bool> = "cut-recovering", false;
        /// How far the laser's recovery is: 0 to 5.
        laser_recovery_state: Out<i32> = "laser-recovery-state", 0;
        /// Height control moves down.
        led_down: Out<bool> = "led-down", false;
        /// Height control moves up.
        led_up: Out<bool> = "led-up", false;
        /// The path is being moved along while paused.
        paused_motion: Out<bool> = "paused-motion", false;
        /// Z came to its lowest in a probe test.
        probe_test_error: Out<bool> = "probe-test-error", false;
        /// The safe height is less than what is wanted.
        safe_height_limited: Out<bool> = "safe-height-is-limited", false;
        /// A switch or the contact is active.
        sensor_active: Out<bool> = "sensor-active", false;
        /// What it does, as a number.
        state: Out<i32> = "state-out", 0;
        /// Why a cut ended: 0 nothing, 1 the program, 2 the end of a cut, 3 a pause or a fault.
        stop_type: Out<i32> = "stop-type-out", 0;
        /// The height is being controlled.
        thc_active: Out<bool> = "thc-active", false;
        /// The height may be controlled.
        thc_enabled: Out<bool> = "thc-enabled", false;
        /// The voltage that height control keeps, in volts.
        target_volts: Out<f64> = "target-volts", 0.0;
        /// Height above the surface, or above the lowest Z before a surface is known, in machine units.
        z_height: Out<f64> = "z-height", 0.0;
        /// Distance from the last surface, in machine units: always 0 here, as LinuxCNC was seen to do.
        z_relative: Out<f64> = "z-relative", 0.0;
        /// Feed rate now, in machine units per minute.
        current_feed_rate: Out<f64> = "current-feed-rate", 0.0;
        /// Feed rate that the program wants, in its units per minute.
        requested_feed_rate: Out<f64> = "requested-feed-rate", 0.0;
    }
}

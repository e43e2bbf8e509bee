//! Input pins of `plasmac` with settings and requests: cut, torch height control and jobs.

use hal_component::{In, pins};

pins! {
    /// Heights, speeds and times of a cut.
    pub(super) struct Cut {
        /// Height of the torch while it pierces, in machine units.
        pierce_height: In<f64> = "pierce-height", 0.0;
        /// Time to pierce, in seconds.
        pierce_delay: In<f64> = "pierce-delay", 0.0;
        /// Height of the torch while it cuts, in machine units.
        cut_height: In<f64> = "cut-height", 0.0;
        /// Arc voltage of the cut, in volts; must be above 0.
        cut_volts: In<f64> = "cut-volts", 0.0;
        /// Feed rate of the cut, in machine units per minute.
        cut_feed_rate: In<f64> = "cut-feed-rate", 0.0;
        /// Kerf width, in machine units; not used here.
        kerf_width: In<f64> = "kerf-width", 0.0;
        /// Height of the puddle jump, in percent of the pierce height; 0: no puddle jump.
        puddle_jump_height: In<f64> = "puddle-jump-height", 0.0;
        /// Time at the puddle jump height, in seconds.
        puddle_jump_delay: In<f64> = "puddle-jump-delay", 0.0;
        /// Time for which the torch stays on at the end of a cut, in seconds.
        pause_at_end: In<f64> = "pause-at-end", 0.0;
        /// Height above the surface between cuts, in machine units; 0: as high as possible.
        safe_height: In<f64> = "safe-height", 0.0;
        /// Speed of Z to the pierce height and the cut height, in machine units per minute.
        setup_feed_rate: In<f64> = "setup-feed-rate", 0.0;
        /// Counts of an offset per `offset-scale` unit; 1 to 1000.
        resolution: In<i32> = "resolution", 100;
        /// Distance that height control keeps below the upper limit of Z, in millimetres.
        max_offset: In<i32> = "max-offset", 5;
        /// Allows the torch to be lit; FALSE makes a cut a dry run.
        torch_enable: In<bool> = "torch-enable", false;
        /// Turns the torch off during a cut.
        torch_off: In<bool> = "torch-off", false;
        /// Lights the torch for `torch-pulse-time`.
        torch_pulse_start: In<bool> = "torch-pulse-start", false;
        /// Duration of a torch pulse, in seconds.
        torch_pulse_time: In<f64> = "torch-pulse-time", 0.0;
        /// Arc OK source: 0 the arc voltage, 1 `arc-ok-in`, 2 `arc-ok-in` with height control by `move-up` and
        /// `move-down`.
        mode: In<i32> = "mode", 0;
        /// Mesh mode: cuts without torch height control.
        mesh_enable: In<bool> = "mesh-enable", false;
        /// Cuts without an arc in mesh mode.
        mesh_arc_ok: In<bool> = "mesh-arc-ok", false;
    }
}

pins! {
    /// Torch height control.
    pub(super) struct Thc {
        /// Enables control of the torch height by the arc voltage.
        enable: In<bool> = "thc-enable", false;
        /// Disables height control at the program's request.
        disable: In<bool> = "thc-disable", false;
        /// Sets the target as soon as the voltage is steady, with `use-auto-volts`.
        auto: In<bool> = "thc-auto", false;
        /// Time from reaching the feed rate to the start of height control, in seconds.
        delay: In<f64> = "thc-delay", 0.0;
        /// Maximum speed of Z, in machine units per minute.
        feed_rate: In<f64> = "thc-feed-rate", 0.0;
        /// With `thc-auto`, number of cycles for which the voltage must be steady; 1 to 1000.
        sample_counts: In<i32> = "thc-sample-counts", 50;
        /// Largest voltage difference among these cycles, in volts.
        sample_threshold: In<f64> = "thc-sample-threshold", 1.0;
        /// Deadband: smaller errors of the voltage, in volts, do not move Z.
        threshold: In<f64> = "thc-threshold", 0.0;
        /// Takes the target from the voltage measured at the cut height; FALSE: from `cut-volts`.
        use_auto_volts: In<bool> = "use-auto-volts", false;
        /// Number of voltage samples that the target averages.
        target_samples: In<i32> = "target-samples", 6;
        /// Volts that the user adds to the target.
        height_override: In<f64> = "height-override", 0.0;
        /// Change of height per volt of `height-override`, in machine units.
        height_per_volt: In<f64> = "height-per-volt", 0.0;
        /// Proportional gain, in tenths of `resolution` counts per volt of error.
        p_gain: In<f64> = "pid-p-gain", 0.0;
        /// Integral gain, in the same counts per volt of error and second; it does not accumulate over cycles.
        i_gain: In<f64> = "pid-i-gain", 0.0;
        /// Derivative gain, in the same counts per volt per second.
        d_gain: In<f64> = "pid-d-gain", 0.0;
        /// Suspends height control in corners.
        cornerlock_enable: In<bool> = "cornerlock-enable", false;
        /// Speed, in percent of the feed rate, below which a move counts as a corner.
        cornerlock_threshold: In<f64> = "cornerlock-threshold", 0.0;
        /// Suspends height control over voids, which a fast rise of the voltage indicates.
        voidlock_enable: In<bool> = "voidlock-enable", false;
        /// Number of cycles after the first for which the voltage must rise before a void is detected.
        voidlock_on_cycles: In<i32> = "voidlock-on-cycles", 2;
        /// Number of cycles without a fast change before a void is over; 0: voids are not detected.
        voidlock_off_cycles: In<i32> = "voidlock-off-cycles", 10;
        /// Rate of rise that counts as fast, in volts per second.
        voidlock_slope: In<i32> = "voidlock-slope", 500;
        /// Voltage below which the cut ends while height control works, in volts; 0: never.
        low_cut_volts: In<i32> = "low-cut-volts", 0;
        /// Moves Z up, with `mode` 2.
        move_up: In<bool> = "move-up", false;
        /// Moves Z down, with `mode` 2.
        move_down: In<bool> = "move-down", false;
    }
}

pins! {
    /// Requests that start a cut or another job.
    pub(super) struct Jobs {
        /// Starts a cut, from `spindle.0.on`; the falling edge ends it.
        cutting_start: In<bool> = "cutting-start", false;
        /// Starts scribing, from `spindle.1.on`.
        scribe_start: In<bool> = "scribe-start", false;
        /// Time from the scribe arm to the scribe, in seconds.
        scribe_arm_delay: In<f64> = "scribe-arm-delay", 0.0;
        /// Time from the scribe to the move, in seconds.
        scribe_on_delay: In<f64> = "scribe-on-delay", 0.0;
        /// Starts a spot, from `spindle.2.on`.
        spotting_start: In<bool> = "spotting-start", false;
        /// Voltage from which the time of a spot counts, in volts.
        spotting_threshold: In<f64> = "spotting-threshold", 0.0;
        /// Duration of a spot, in milliseconds.
        spotting_time: In<f64> = "spotting-time", 0.0;
        /// While paused, moves to the position for changing consumables; FALSE: moves back.
        consumable_change: In<bool> = "consumable-change", false;
        /// While paused, moves to the position where the cut resumes.
        cut_recovery: In<bool> = "cut-recovery", false;
        /// X offset of that position, in counts.
        x_offset: In<i32> = "x-offset", 0;
        /// Y offset of that position, in counts.
        y_offset: In<i32> = "y-offset", 0;
        /// Speed of the move for changing consumables, in machine units per minute.
        xy_feed_rate: In<f64> = "xy-feed-rate", 0.0;
        /// 1 places the laser over the position where the cut resumes.
        laser_recovery_start: In<i32> = "laser-recovery-start", 0;
        /// Laser offset from the torch in X, in counts.
        laser_x_offset: In<i32> = "laser-x-offset", 0;
        /// Laser offset from the torch in Y, in counts.
        laser_y_offset: In<i32> = "laser-y-offset", 0;
        /// While paused, moves along the path at this fraction of the feed rate, -1 to 1; negative is backward.
        paused_motion_speed: In<f64> = "paused-motion-speed", 0.0;
        /// Allows jogging although a sensor is active.
        override_jog: In<bool> = "override-jog", false;
        /// Selects more than one tool; not used here.
        multi_tool: In<bool> = "multi-tool", true;
        /// Reports every change of state.
        debug_print: In<bool> = "debug-print", false;
    }
}

//! The pins of `plasmac` that say what is wanted: the cut, the torch height, other jobs.

use hal_component::{In, pins};

pins! {
    /// A cut: heights, speeds, times.
    pub(super) struct Cut {
        /// Height of the torch while it pierces, in machine units.
        pierce_height: In<f64> = "pierce-height", 0.0;
        /// Seconds to pierce.
        pierce_delay: In<f64> = "pierce-delay", 0.0;
        /// Height of the torch while it cuts, in machine units.
        cut_height: In<f64> = "cut-height", 0.0;
        /// Voltage of the cut, in volts; must be above 0.
        cut_volts: In<f64> = "cut-volts", 0.0;
        /// Feed rate of the cut, in machine units per minute.
        cut_feed_rate: In<f64> = "cut-feed-rate", 0.0;
        /// Width of the cut, in machine units; not used here.
        kerf_width: In<f64> = "kerf-width", 0.0;
        /// Height of the puddle jump, in percent of the pierce height; 0: none.
        puddle_jump_height: In<f64> = "puddle-jump-height", 0.0;
        /// Seconds at the height of the puddle jump.
        puddle_jump_delay: In<f64> = "puddle-jump-delay", 0.0;
        /// Seconds that the torch stays on at the end of a cut.
        pause_at_end: In<f64> = "pause-at-end", 0.0;
        /// Height above the surface between cuts, in machine units; 0: as high as it can.
        safe_height: In<f64> = "safe-height", 0.0;
        /// Speed of Z to the pierce height and the cut height, in machine units per minute.
        setup_feed_rate: In<f64> = "setup-feed-rate", 0.0;
        /// Counts of an offset for each unit of `offset-scale`; 1 to 1000.
        resolution: In<i32> = "resolution", 100;
        /// How far Z stays below its highest, in millimetres, for torch height control.
        max_offset: In<i32> = "max-offset", 5;
        /// The torch may be lit; else a cut is a dry run.
        torch_enable: In<bool> = "torch-enable", false;
        /// Puts the torch out during a cut.
        torch_off: In<bool> = "torch-off", false;
        /// Lights the torch for `torch-pulse-time`.
        torch_pulse_start: In<bool> = "torch-pulse-start", false;
        /// Seconds of a torch pulse.
        torch_pulse_time: In<f64> = "torch-pulse-time", 0.0;
        /// What makes and loses an arc: 0 the voltage, 1 `arc-ok-in`, 2 `arc-ok-in` with `move-up` and `move-down`.
        mode: In<i32> = "mode", 0;
        /// Cuts a mesh: no torch height control.
        mesh_enable: In<bool> = "mesh-enable", false;
        /// No arc is needed while a mesh is cut.
        mesh_arc_ok: In<bool> = "mesh-arc-ok", false;
    }
}

pins! {
    /// Torch height control.
    pub(super) struct Thc {
        /// Controls the height of the torch by the voltage.
        enable: In<bool> = "thc-enable", false;
        /// The program wants no height control now.
        disable: In<bool> = "thc-disable", false;
        /// Takes the target as soon as the voltage is steady, with `use-auto-volts`.
        auto: In<bool> = "thc-auto", false;
        /// Seconds from the feed rate reached to the begin.
        delay: In<f64> = "thc-delay", 0.0;
        /// Highest speed of Z, in machine units per minute.
        feed_rate: In<f64> = "thc-feed-rate", 0.0;
        /// With `thc-auto`, for how many runs the voltage must be steady.
        sample_counts: In<i32> = "thc-sample-counts", 50;
        /// By how many volts it may differ meanwhile.
        sample_threshold: In<f64> = "thc-sample-threshold", 1.0;
        /// Smaller differences of the voltage move nothing, in volts.
        threshold: In<f64> = "thc-threshold", 0.0;
        /// Takes the target from the voltage at the cut height; else from `cut-volts`.
        use_auto_volts: In<bool> = "use-auto-volts", false;
        /// Of how many voltages that target is the mean.
        target_samples: In<i32> = "target-samples", 6;
        /// Volts added to the target by the user.
        height_override: In<f64> = "height-override", 0.0;
        /// Height of one volt of `height-override`, in machine units.
        height_per_volt: In<f64> = "height-per-volt", 0.0;
        /// Proportional gain, in tenths of `resolution` counts for a volt of error.
        p_gain: In<f64> = "pid-p-gain", 0.0;
        /// Integral gain, in the same counts for a volt of error and a second; it does not add up over cycles.
        i_gain: In<f64> = "pid-i-gain", 0.0;
        /// Derivative gain, in the same counts for a volt per second.
        d_gain: In<f64> = "pid-d-gain", 0.0;
        /// Stops height control in corners.
        cornerlock_enable: In<bool> = "cornerlock-enable", false;
        /// A corner is a speed below this, in percent of the feed rate.
        cornerlock_threshold: In<f64> = "cornerlock-threshold", 0.0;
        /// Stops height control over voids, which a quick rise of the voltage tells.
        voidlock_enable: In<bool> = "voidlock-enable", false;
        /// For how many runs after the first the voltage must rise.
        voidlock_on_cycles: In<i32> = "voidlock-on-cycles", 2;
        /// For how many runs it must not, before the void is over; 0: there are no voids.
        voidlock_off_cycles: In<i32> = "voidlock-off-cycles", 10;
        /// A quick rise, in volts per second.
        voidlock_slope: In<i32> = "voidlock-slope", 500;
        /// Below this voltage the cut ends while height is controlled; 0: never.
        low_cut_volts: In<i32> = "low-cut-volts", 0;
        /// With `mode` 2, moves up.
        move_up: In<bool> = "move-up", false;
        /// With `mode` 2, moves down.
        move_down: In<bool> = "move-down", false;
    }
}

pins! {
    /// What begins a job, and the jobs beside cuts.
    pub(super) struct Jobs {
        /// Begins a cut, from `spindle.0.on`; ends it as it falls.
        cutting_start: In<bool> = "cutting-start", false;
        /// Begins to scribe, from `spindle.1.on`.
        scribe_start: In<bool> = "scribe-start", false;
        /// Seconds from the scribe's arm to the scribe.
        scribe_arm_delay: In<f64> = "scribe-arm-delay", 0.0;
        /// Seconds from the scribe to the move.
        scribe_on_delay: In<f64> = "scribe-on-delay", 0.0;
        /// Begins a spot, from `spindle.2.on`.
        spotting_start: In<bool> = "spotting-start", false;
        /// From which voltage the time of a spot counts.
        spotting_threshold: In<f64> = "spotting-threshold", 0.0;
        /// Time of a spot, in milliseconds.
        spotting_time: In<f64> = "spotting-time", 0.0;
        /// While paused, moves to where consumables are changed; FALSE: back.
        consumable_change: In<bool> = "consumable-change", false;
        /// While paused, moves to where the cut goes on.
        cut_recovery: In<bool> = "cut-recovery", false;
        /// Where that is in X, in counts.
        x_offset: In<i32> = "x-offset", 0;
        /// Where that is in Y, in counts.
        y_offset: In<i32> = "y-offset", 0;
        /// Speed to where consumables are changed, in machine units per minute.
        xy_feed_rate: In<f64> = "xy-feed-rate", 0.0;
        /// 1 lays the laser onto where the cut goes on.
        laser_recovery_start: In<i32> = "laser-recovery-start", 0;
        /// Distance of the laser in X, in counts.
        laser_x_offset: In<i32> = "laser-x-offset", 0;
        /// Distance of the laser in Y, in counts.
        laser_y_offset: In<i32> = "laser-y-offset", 0;
        /// While paused, moves along the path at this part of the feed rate, -1 to 1.
        paused_motion_speed: In<f64> = "paused-motion-speed", 0.0;
        /// Jogging is allowed though a sensor is active.
        override_jog: In<bool> = "override-jog", false;
        /// More than one tool; not used here.
        multi_tool: In<bool> = "multi-tool", true;
        /// Tells every change of state.
        debug_print: In<bool> = "debug-print", false;
    }
}

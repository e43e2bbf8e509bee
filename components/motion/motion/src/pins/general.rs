//! Pins and parameters that exist once.

use super::pins;
use hal_component::{In, Out, ParamRo, ParamRw};

pins! {
    /// Pins of motion as a whole.
    GeneralPins {
        /// Factor (a ratio) for the feed of coordinated moves, if `motion.feed adaptive=1` switched it on: 0 to the
        /// highest override. Below 0 the path runs backwards at that factor. NaN counts as 0.
        adaptive_feed: In<f64> = 1.0, "adaptive-feed";
        /// TRUE stops coordinated moves along their path until it is FALSE, unless
        /// `motion.feed hold=0` switched it off.
        feed_hold: In<bool> = false, "feed-hold";
        /// TRUE stops coordinated moves along their path until it is FALSE.
        feed_inhibit: In<bool> = false, "feed-inhibit";
        /// FALSE switches the machine off and keeps it off.
        enable: In<bool> = true, "enable" [safety];
        /// TRUE when a probe touches: ends probe moves, and jogs and homing that are in progress.
        probe_input: In<bool> = false, "probe-input";
        /// TRUE refuses to begin homing.
        homing_inhibit: In<bool> = false, "homing-inhibit";
        /// TRUE refuses to begin a jog.
        jog_inhibit: In<bool> = false, "jog-inhibit";
        /// Going TRUE brakes every jog to a stop.
        jog_stop: In<bool> = false, "jog-stop";
        /// Going TRUE ends every jog at once, without braking: drives may lose position.
        jog_stop_immediate: In<bool> = false, "jog-stop-immediate";
        /// TRUE while the machine is on.
        motion_enabled: Out<bool> = false, "motion-enabled";
        /// TRUE while nothing moves and nothing waits to move.
        in_position: Out<bool> = false, "in-position";
        /// TRUE in coordinated mode. As teleop mode it needs kinematics that lead from the joints to
        /// a pose and back to the same joints.
        coord_mode: Out<bool> = false, "coord-mode";
        /// TRUE in teleop mode: jogs move axes instead of joints.
        teleop_mode: Out<bool> = false, "teleop-mode";
        /// TRUE after a coordinated move was refused, until the next one is accepted.
        coord_error: Out<bool> = false, "coord-error";
        /// TRUE while a homed joint is beyond a soft limit in coordinated or teleop mode.
        on_soft_limit: Out<bool> = false, "on-soft-limit";
        /// TRUE when every active joint is homed; also when none is active.
        is_all_homed: Out<bool> = false, "is-all-homed";
        /// TRUE while a jog moves a joint or an axis.
        jog_is_active: Out<bool> = false, "jog-is-active";
        /// TRUE while any external offset is applied.
        eoffset_active: Out<bool> = false, "eoffset-active";
        /// TRUE while a soft limit keeps an external offset from its requested value.
        eoffset_limited: Out<bool> = false, "eoffset-limited";
        /// TRUE while a path is run backwards.
        tp_reverse: Out<bool> = false, "tp-reverse";
        /// Current velocity, in machine units per second: along the path in coordinated mode, otherwise of all jogs
        /// together.
        current_vel: Out<f64> = 0.0, "current-vel";
        /// Requested velocity of the coordinated move within the machine's limits, in machine units per second, before
        /// feed override.
        requested_vel: Out<f64> = 0.0, "requested-vel";
        /// Remaining distance of the current coordinated move, in machine units.
        distance_to_go: Out<f64> = 0.0, "distance-to-go";
        /// Feed of the coordinated move, override applied, in machine units per minute.
        feed_upm: Out<f64> = 0.0, "feed-upm";
        /// Feed of the coordinated move in inches per minute.
        feed_inches_per_minute: Out<f64> = 0.0, "feed-inches-per-minute";
        /// Feed of the coordinated move in inches per second.
        feed_inches_per_second: Out<f64> = 0.0, "feed-inches-per-second";
        /// Feed of the coordinated move in millimetres per minute.
        feed_mm_per_minute: Out<f64> = 0.0, "feed-mm-per-minute";
        /// Feed of the coordinated move in millimetres per second.
        feed_mm_per_second: Out<f64> = 0.0, "feed-mm-per-second";
        /// Type of the current motion: 0 none, 1 rapid, 2 feed, 3 arc, 4 tool change, 5 probing, 6 rotary index.
        /// It is 0 to 3 or 5 here so far.
        motion_type: Out<i32> = 0, "motion-type";
        /// Line of the program being run, as the move gave it; 0 without a move.
        program_line: Out<i32> = 0, "program-line";
        /// Machine time between the last two cycles in nanoseconds.
        last_period: Out<u32> = 0, "servo.last-period";
        /// Tool offset of the program in x, in units or degrees (motion.tool-offset).
        tooloffset_x: Out<f64> = 0.0, "tooloffset.x";
        /// Tool offset of the program in y, in units or degrees (motion.tool-offset).
        tooloffset_y: Out<f64> = 0.0, "tooloffset.y";
        /// Tool offset of the program in z, in units or degrees (motion.tool-offset).
        tooloffset_z: Out<f64> = 0.0, "tooloffset.z";
        /// Tool offset of the program in a, in units or degrees (motion.tool-offset).
        tooloffset_a: Out<f64> = 0.0, "tooloffset.a";
        /// Tool offset of the program in b, in units or degrees (motion.tool-offset).
        tooloffset_b: Out<f64> = 0.0, "tooloffset.b";
        /// Tool offset of the program in c, in units or degrees (motion.tool-offset).
        tooloffset_c: Out<f64> = 0.0, "tooloffset.c";
        /// Tool offset of the program in u, in units or degrees (motion.tool-offset).
        tooloffset_u: Out<f64> = 0.0, "tooloffset.u";
        /// Tool offset of the program in v, in units or degrees (motion.tool-offset).
        tooloffset_v: Out<f64> = 0.0, "tooloffset.v";
        /// Tool offset of the program in w, in units or degrees (motion.tool-offset).
        tooloffset_w: Out<f64> = 0.0, "tooloffset.w";
        /// TRUE while an arc is run.
        interp_iscircle: Out<bool> = false, "interp.iscircle";
        /// Centre of the arc in x, in units; 0 without an arc.
        interp_arc_center_x: Out<f64> = 0.0, "interp.arc-center-x";
        /// Centre of the arc in y, in units; 0 without an arc.
        interp_arc_center_y: Out<f64> = 0.0, "interp.arc-center-y";
        /// Centre of the arc in z, in units; 0 without an arc.
        interp_arc_center_z: Out<f64> = 0.0, "interp.arc-center-z";
        /// Radius of the arc at its start, in units; 0 without an arc.
        interp_arc_radius: Out<f64> = 0.0, "interp.arc-radius";
        /// Velocity that the current move requests, in machine units per second.
        interp_feedrate: Out<f64> = 0.0, "interp.feedrate";
        /// Direction of the path in x and y, counter-clockwise from x, in degrees, -180 to 180; the last one while x and y
        /// rest.
        interp_heading: Out<f64> = 0.0, "interp.heading";
        /// Direction across the path, to its left: heading and 90 degrees, -180 to 180.
        interp_normal_heading: Out<f64> = 0.0, "interp.normal-heading";
        /// Line of the current move: as program-line.
        interp_line_number: Out<i32> = 0, "interp.line-number";
        /// Kind of the current move: as motion-type.
        interp_motion_type: Out<i32> = 0, "interp.motion-type";
    }
}

pins! {
    /// Pins and parameter of the watchman, which judges the commands of all motors.
    WatchPins {
        /// Number of cycles so far in which a joint broke a limit, counted for each joint.
        violations: Out<u32> = 0, "watch.violations";
        /// Number of stops at once so far: machine off in motion, and jog-stop-immediate. They are not judged.
        hard_stops: Out<u32> = 0, "watch.hard-stops";
        /// Highest ratio of a joint's velocity, acceleration or jerk to its limit so far.
        worst: Out<f64> = 0.0, "watch.worst";
        /// Joint of the highest ratio.
        joint: Out<i32> = 0, "watch.joint";
        /// Line of the program at the highest ratio; 0 without a program.
        line: Out<i32> = 0, "watch.line";
        /// TRUE sets all counters and ratios back.
        reset: In<bool> = false, "watch.reset";
        /// TRUE: a violation switches the machine off. FALSE: it is only counted, and the first one reported.
        stop: ParamRw<bool> = false, "watch.stop";
    }
}

pins! {
    /// Parameters for debugging motion itself.
    Traces {
        /// For experiments: always FALSE.
        debug_bit_0: ParamRo<bool> = false, "motion.debug-bit-0";
        /// For experiments: always FALSE.
        debug_bit_1: ParamRo<bool> = false, "motion.debug-bit-1";
        /// For experiments: always 0.
        debug_float_0: ParamRo<f64> = 0.0, "motion.debug-float-0";
        /// For experiments: always 0.
        debug_float_1: ParamRo<f64> = 0.0, "motion.debug-float-1";
        /// For experiments: always 0.
        debug_float_2: ParamRo<f64> = 0.0, "motion.debug-float-2";
        /// For experiments: always 0.
        debug_float_3: ParamRo<f64> = 0.0, "motion.debug-float-3";
        /// For experiments: always 0.
        debug_s32_0: ParamRo<i32> = 0, "motion.debug-s32-0";
        /// For experiments: always 0.
        debug_s32_1: ParamRo<i32> = 0, "motion.debug-s32-1";
        /// Distance travelled along the current move, in machine units.
        tc_0_pos: ParamRo<f64> = 0.0, "tc.0.pos";
        /// Velocity along the current move, in machine units per second.
        tc_0_vel: ParamRo<f64> = 0.0, "tc.0.vel";
        /// Acceleration along the current move, in machine units per second squared; 0 without one.
        tc_0_acc: ParamRo<f64> = 0.0, "tc.0.acc";
        /// Position along the move that is number 1 after the current one: always 0, because it has not begun.
        tc_1_pos: ParamRo<f64> = 0.0, "tc.1.pos";
        /// Velocity along the move that is number 1 after the current one: always 0, because it has not begun.
        tc_1_vel: ParamRo<f64> = 0.0, "tc.1.vel";
        /// Acceleration along the move that is number 1 after the current one: always 0, because it has not begun.
        tc_1_acc: ParamRo<f64> = 0.0, "tc.1.acc";
        /// Position along the move that is number 2 after the current one: always 0, because it has not begun.
        tc_2_pos: ParamRo<f64> = 0.0, "tc.2.pos";
        /// Velocity along the move that is number 2 after the current one: always 0, because it has not begun.
        tc_2_vel: ParamRo<f64> = 0.0, "tc.2.vel";
        /// Acceleration along the move that is number 2 after the current one: always 0, because it has not begun.
        tc_2_acc: ParamRo<f64> = 0.0, "tc.2.acc";
        /// Position along the move that is number 3 after the current one: always 0, because it has not begun.
        tc_3_pos: ParamRo<f64> = 0.0, "tc.3.pos";
        /// Velocity along the move that is number 3 after the current one: always 0, because it has not begun.
        tc_3_vel: ParamRo<f64> = 0.0, "tc.3.vel";
        /// Acceleration along the move that is number 3 after the current one: always 0, because it has not begun.
        tc_3_acc: ParamRo<f64> = 0.0, "tc.3.acc";
        /// Distance travelled along the current move, in machine units: as tc.0.pos.
        traj_pos_out: ParamRo<f64> = 0.0, "traj.pos_out";
        /// Velocity along the path, in machine units per second, negative in reverse.
        traj_vel_out: ParamRo<f64> = 0.0, "traj.vel_out";
        /// Number of the current move, from 1; 0 without one.
        traj_active_tc: ParamRo<u32> = 0, "traj.active_tc";
    }
}

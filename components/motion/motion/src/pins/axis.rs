//! Pins of an axis.

use super::pins;
use hal_component::{In, Out};

pins! {
    /// Pins of one axis letter.
    AxisPins {
        /// Commanded position of the axis in machine units or degrees.
        pos_cmd: Out<f64> = 0.0, "pos-cmd";
        /// Target of the axis planner of teleop mode, in machine units or degrees.
        teleop_pos_cmd: Out<f64> = 0.0, "teleop-pos-cmd";
        /// Velocity of the axis planner of teleop mode, in units per second.
        teleop_vel_cmd: Out<f64> = 0.0, "teleop-vel-cmd";
        /// Velocity limit of the axis planner of teleop mode, in units per second.
        teleop_vel_lim: Out<f64> = 0.0, "teleop-vel-lim";
        /// TRUE while the axis planner of teleop mode is switched on.
        teleop_tp_enable: Out<bool> = false, "teleop-tp-enable";
        /// TRUE while a commanded jog moves the axis.
        kb_jog_active: Out<bool> = false, "kb-jog-active";
        /// TRUE while the jog wheel moves the axis.
        wheel_jog_active: Out<bool> = false, "wheel-jog-active";
        /// Counts of a jog wheel; only differences matter, and the count may wrap.
        jog_counts: In<i32> = 0, "jog-counts";
        /// TRUE lets jog-counts move the axis, in teleop mode.
        jog_enable: In<bool> = false, "jog-enable";
        /// Distance for one count of the wheel in units; NaN and infinity count as zero.
        jog_scale: In<f64> = 0.0, "jog-scale";
        /// TRUE: the axis stops when the wheel does; FALSE: it travels the whole distance counted.
        jog_vel_mode: In<bool> = false, "jog-vel-mode";
        /// Acceleration for the wheel as a fraction of the axis's, 0 to 1; anything else counts
        /// as 1, and 0 means that the wheel moves nothing.
        jog_accel_fraction: In<f64> = 1.0, "jog-accel-fraction";
        /// External offset applied, in units or degrees; pos-cmd does not include it.
        eoffset: Out<f64> = 0.0, "eoffset";
        /// External offset requested, in units or degrees; limits may keep eoffset from reaching it.
        eoffset_request: Out<f64> = 0.0, "eoffset-request";
        /// TRUE lets eoffset-counts shift the axis, when all joints are homed, the mode is teleop or coordinated, and
        /// the axis has an offset-av-ratio (motion.configure).
        eoffset_enable: In<bool> = false, "eoffset-enable";
        /// TRUE returns the external offset to zero, and keeps it there.
        eoffset_clear: In<bool> = false, "eoffset-clear";
        /// Counts of the external offset; only differences matter, and the count may wrap. While the machine is off the
        /// offset is zero, and it stays zero when the machine comes on.
        eoffset_counts: In<i32> = 0, "eoffset-counts";
        /// Distance for one count of the external offset in units or degrees; NaN and infinity leave the offset
        /// unchanged.
        eoffset_scale: In<f64> = 0.0, "eoffset-scale";
    }
}

//! Pins of a joint.

use super::pins;
use crate::jogger::WheelPins;
use hal_component::{Builder, Decl, Error, In, Io, Out, ParamRo};

pins! {
    /// Pins of one joint.
    JointPins {
        /// Position command for the motor in machine units: pos-cmd plus backlash-filt and motor-offset. While the
        /// machine is off it follows motor-pos-fb. A step longer than max-velocity allows in one cycle is not written:
        /// the machine goes off, with a message that names the source of the motion.
        motor_pos_cmd: Out<f64> = 0.0, "motor-pos-cmd" was "motor-pos-cmd";
        /// Position of the motor, measured, in machine units. NaN and infinity count as a following error.
        motor_pos_fb: In<f64> = 0.0, "motor-pos-fb" was "motor-pos-fb";
        /// Commanded position in machine units, before backlash and home offset.
        pos_cmd: Out<f64> = 0.0, "pos-cmd" was "joint-pos-cmd";
        /// Measured position in machine units: motor-pos-fb minus backlash-filt and motor-offset. Stays unchanged while
        /// the joint is not active.
        pos_fb: Out<f64> = 0.0, "pos-fb" was "joint-pos-fb";
        /// Commanded velocity in machine units per second.
        vel_cmd: Out<f64> = 0.0, "vel-cmd" was "joint-vel-cmd";
        /// Commanded acceleration in machine units per second squared.
        acc_cmd: Out<f64> = 0.0, "acc-cmd";
        /// Commanded jerk in machine units per second cubed.
        jerk_cmd: Out<f64> = 0.0, "jerk-cmd";
        /// Commanded position before interpolation in machine units. Nothing is interpolated between servo cycles, so it
        /// equals pos-cmd.
        coarse_pos_cmd: Out<f64> = 0.0, "coarse-pos-cmd" was "coarse-pos-cmd";
        /// Offset found by homing: the motor's position in machine units where the joint is at zero.
        motor_offset: Out<f64> = 0.0, "motor-offset" was "motor-offset";
        /// Target of the correction, in machine units: half the backlash, positive after movement in positive
        /// direction; with comp-file the screw's error at pos-cmd for that direction, once the joint is homed.
        backlash_corr: Out<f64> = 0.0, "backlash-corr" was "backlash-corr";
        /// Correction applied, in machine units: follows backlash-corr with the part comp-av-ratio of the
        /// joint's velocity and acceleration, which moves do not use.
        backlash_filt: Out<f64> = 0.0, "backlash-filt" was "backlash-filt";
        /// Velocity of backlash-filt in machine units per second.
        backlash_vel: Out<f64> = 0.0, "backlash-vel" was "backlash-vel";
        /// Following error in machine units: pos-cmd minus pos-fb.
        f_error: Out<f64> = 0.0, "f-error" was "f-error";
        /// Following error allowed at the current velocity, in machine units: the joint's ferror times velocity divided
        /// by the highest velocity, and never less than min-ferror.
        f_error_lim: Out<f64> = 0.0, "f-error-lim" was "f-error-lim";
        /// Target of the joint's own planner, in machine units.
        free_pos_cmd: Out<f64> = 0.0, "free-pos-cmd" was "free-pos-cmd";
        /// Velocity limit of the joint's own planner in machine units per second.
        free_vel_lim: Out<f64> = 0.0, "free-vel-lim" was "free-vel-lim";
        /// Highest ratio of the velocity to its limit for moves so far; above 1 is a violation.
        watch_velocity: Out<f64> = 0.0, "watch-velocity";
        /// Highest ratio of the acceleration to its limit for moves so far; above 1 is a violation.
        watch_acceleration: Out<f64> = 0.0, "watch-acceleration";
        /// Highest ratio of the jerk to its limit so far; 0 without a limit.
        watch_jerk: Out<f64> = 0.0, "watch-jerk";
        /// TRUE while the joint is configured and takes part.
        active: Out<bool> = false, "active" was "active";
        /// TRUE to switch the amplifier on: the machine is on and the joint active.
        amp_enable_out: Out<bool> = false, "amp-enable-out" was "amp-enable-out";
        /// TRUE from the amplifier when it has a fault: switches the machine off.
        amp_fault_in: In<bool> = false, "amp-fault-in" was "amp-fault-in" [safety];
        /// TRUE after the joint switched the machine off, until it is switched on again.
        error: Out<bool> = false, "error" was "error";
        /// TRUE when the following error is beyond its limit.
        f_errored: Out<bool> = false, "f-errored" was "f-errored";
        /// TRUE while amp-fault-in is TRUE.
        faulted: Out<bool> = false, "faulted" was "faulted";
        /// TRUE while the joint's own planner is at rest.
        in_position: Out<bool> = false, "in-position" was "in-position";
        /// TRUE from the limit switch at the positive end: switches the machine off unless the
        /// joint is homing or the limits are overridden.
        pos_lim_sw_in: In<bool> = false, "pos-lim-sw-in" was "pos-lim-sw-in" [safety];
        /// TRUE from the limit switch at the negative end: same effect as pos-lim-sw-in.
        neg_lim_sw_in: In<bool> = false, "neg-lim-sw-in" was "neg-lim-sw-in" [safety];
        /// TRUE while pos-lim-sw-in of an active joint is TRUE.
        pos_hard_limit: Out<bool> = false, "pos-hard-limit" was "pos-hard-limit";
        /// TRUE while neg-lim-sw-in of an active joint is TRUE.
        neg_hard_limit: Out<bool> = false, "neg-hard-limit" was "neg-hard-limit";
        /// Counts of a jog wheel; only differences matter, and the count may wrap.
        jog_counts: In<i32> = 0, "jog-counts" was "jog-counts";
        /// TRUE lets jog-counts move the joint, in free mode.
        jog_enable: In<bool> = false, "jog-enable" was "jog-enable";
        /// Distance for one count of the wheel in machine units; NaN and infinity count as zero.
        jog_scale: In<f64> = 0.0, "jog-scale" was "jog-scale";
        /// TRUE: the joint stops when the wheel does; FALSE: it travels the whole distance counted.
        jog_vel_mode: In<bool> = false, "jog-vel-mode" was "jog-vel-mode";
        /// Acceleration for the wheel as a fraction of the joint's, 0 to 1; anything else counts
        /// as 1, and 0 means that the wheel moves nothing.
        jog_accel_fraction: In<f64> = 1.0, "jog-accel-fraction";
        /// TRUE while the joint's own planner is switched on.
        free_tp_enable: Out<bool> = false, "free-tp-enable" was "free-tp-enable";
        /// TRUE while a commanded jog moves the joint.
        kb_jog_active: Out<bool> = false, "kb-jog-active" was "kb-jog-active";
        /// TRUE while the jog wheel moves the joint.
        wheel_jog_active: Out<bool> = false, "wheel-jog-active" was "wheel-jog-active";
    }
    /// Pins for homing; none with a homing module of the user, which makes those that it has.
    optional homing: HomingPins
}

pins! {
    /// Pins of one joint for homing by the controller itself.
    HomingPins {
        /// TRUE when the joint's position is known.
        homed: Out<bool> = false, "homed" was "homed";
        /// TRUE while the joint is being homed.
        homing: Out<bool> = false, "homing" was "homing";
        /// Step of homing; 0 while the joint is not being homed.
        home_state: Out<i32> = 0, "home-state" was "home-state";
        /// TRUE from the home switch, for homing with home-search-vel.
        home_sw_in: In<bool> = false, "home-sw-in" was "home-sw-in";
        /// Index handshake: homing with home-use-index sets it, and the encoder clears it at its index.
        index_enable: Io<bool> = false, "index-enable" was "index-enable";
    }
}

impl JointPins {
    /// Declares the parameter that tells whether a sensor measures motor-pos-fb.
    pub(crate) fn measured(
        &self,
        b: &mut Builder<'_>,
        prefix: &str,
    ) -> Result<ParamRo<bool>, Error> {
        let name = format!("{prefix}motor-pos-fb-measured");
        let doc = "TRUE while a sensor measures motor-pos-fb, such as an encoder. FALSE if it is the count of the \
                   joint's own step generator: a gap in time then unhomes the joint if it moves.";
        b.measured(&self.motor_pos_fb, Decl::new(&name, doc).hidden())
    }

    /// Returns the pins of the jog wheel.
    pub(crate) const fn wheel(&self) -> WheelPins {
        WheelPins {
            counts: self.jog_counts,
            enable: self.jog_enable,
            scale: self.jog_scale,
            vel_mode: self.jog_vel_mode,
            accel_fraction: self.jog_accel_fraction,
        }
    }
}

//! Realtime. One joint: its inputs, its position, and its motor command.

use crate::{
    commands::config::{DEFAULT_SHARE, JointConfig},
    compensation::Tables,
    guards::step::{MotorCommand, StepGuard},
    guards::watch::JointWatch,
    homing::one_joint::Homing,
    jogger::{By, Jogger, TravelLimits},
    lock::Lock,
    pins::{JointPins, Shown, packed},
    setup::is_zero,
    simple_tp::SimpleTp,
};
use libm::fabs;

/// Inputs of this cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointInputs {
    pub(crate) motor_pos_fb: f64,
    pub(crate) amp_fault: bool,
    pub(crate) at_max: bool,
    pub(crate) at_min: bool,
    pub(crate) at_home: bool,
    pub(crate) index_enable: bool,
}

/// State of a joint.
#[derive(Debug, Default)]
pub(crate) struct Joint {
    pub(crate) config: JointConfig,
    /// Share of the limits that the correction has, and the velocity that it leaves to moves.
    share: f64,
    pub(crate) move_velocity: f64,
    /// Lowest and highest position that is not at a soft limit.
    inside: [f64; 2],
    /// True if the joint is configured and takes part.
    pub(crate) active: bool,
    /// True if the joint follows posthome-cmd once homed, instead of the kinematics.
    pub(crate) extra: bool,
    pub(crate) inputs: JointInputs,
    pub(crate) pos_cmd: f64,
    pub(crate) vel_cmd: f64,
    pub(crate) acc_cmd: f64,
    jerk_cmd: f64,
    pub(crate) pos_fb: f64,
    pub(crate) motor_offset: f64,
    pub(crate) ferror: f64,
    pub(crate) ferror_limit: f64,
    /// Value of the pin f-errored: the following error exceeded its limit when measured, before the reaction reset it.
    pub(crate) was_ferrored: bool,
    /// True if the joint switched the machine off.
    pub(crate) error: bool,
    pub(crate) homing: Homing,
    pub(crate) free: Jogger,
    pub(crate) backlash: SimpleTp,
    pub(crate) backlash_want: f64,
    /// Direction of the last movement, true if positive.
    forward: Option<bool>,
    /// Farthest position in that direction.
    farthest: f64,
    pub(crate) lock: Lock,
    /// Guard through which every motor command passes.
    pub(crate) step_guard: StepGuard,
    pub(crate) watch: JointWatch,
    shown: Shown<7>,
}

impl Joint {
    pub(crate) fn new(extra: bool, has_lock: bool) -> Self {
        let mut joint = Self { extra, lock: Lock::new(has_lock), ..Self::default() };
        joint.set_config(JointConfig::default());
        joint
    }

    /// Reads the pins, and computes the following error of the last command.
    pub(crate) fn read_pins(&mut self, pins: &JointPins) {
        let homing = pins.homing.as_ref();
        let [at_home, index_enable] =
            homing.map_or([false; 2], |own| [own.home_sw_in.get(), own.index_enable.get()]);
        self.inputs = JointInputs {
            motor_pos_fb: pins.motor_pos_fb.get(),
            amp_fault: pins.amp_fault_in.get(),
            at_max: pins.pos_lim_sw_in.get(),
            at_min: pins.neg_lim_sw_in.get(),
            at_home,
            index_enable,
        };
        self.measure();
    }

    /// Applies a configuration; returns true if the joint takes part from now on.
    pub(crate) fn configure(&mut self, config: JointConfig) -> bool {
        self.set_config(config);
        self.watch.configure(&config);
        let joins = !self.active;
        if joins {
            self.active = true;
            self.measure();
            self.track_feedback("the joint was configured");
        }
        joins
    }

    fn set_config(&mut self, config: JointConfig) {
        self.share = config.correction_share();
        self.move_velocity = config.move_velocity();
        self.inside = [config.min_limit + SLACK, config.max_limit - SLACK];
        self.config = config;
        // The snapshot shows the limits.
        self.shown = Shown::default();
    }

    fn measure(&mut self) {
        if self.homing.is_at_index(self.inputs.index_enable) && self.config.home.encoder.resets() {
            // The encoder's reading has jumped, not the joint.
            self.pos_fb = self.pos_cmd;
        } else if self.active {
            self.pos_fb = self.inputs.motor_pos_fb - (self.backlash.pos + self.motor_offset);
        }
        let on_its_own = self.extra && self.homing.homed;
        self.ferror = if on_its_own { 0.0 } else { self.pos_cmd - self.pos_fb };
        self.ferror_limit = self.config.ferror_limit(self.vel_cmd);
        self.was_ferrored = self.is_ferrored();
    }

    /// Returns whether the following error exceeds its limit or is NaN.
    pub(crate) fn is_ferrored(&self) -> bool {
        self.active && !(fabs(self.ferror) <= self.ferror_limit && self.ferror.is_finite())
    }

    /// Sets the command to the joint's actual position, while the machine is off.
    pub(crate) fn track_feedback(&mut self, why: &'static str) {
        if self.pos_fb.is_finite() {
            self.pos_cmd = self.pos_fb;
            self.ferror = 0.0;
        }
        (self.vel_cmd, self.acc_cmd, self.jerk_cmd) = (0.0, 0.0, 0.0);
        self.free.reset(self.pos_cmd, why);
    }

    /// Returns the limits of a jog: the soft limits if the joint is homed, otherwise the full distance between them in
    /// both directions from here.
    pub(crate) fn jog_limits(&self) -> TravelLimits {
        let c = &self.config;
        let (min, max) = if self.homing.homed {
            (c.min_limit, c.max_limit)
        } else {
            let range = c.max_limit - c.min_limit;
            (self.pos_fb - range, self.pos_fb + range)
        };
        TravelLimits {
            min,
            max,
            max_vel: c.move_velocity(),
            max_acc: c.move_acceleration(),
            max_jerk: c.move_jerk(),
        }
    }

    /// Returns the reasons, for the ticket and for the operator, why the joint does not jog by itself.
    pub(crate) fn refuses_jog(&self) -> Option<(&'static str, &'static str)> {
        if self.extra && self.homing.homed {
            let why = "cannot jog: a homed extra joint follows posthome-cmd";
            return Some((why, why));
        }
        if self.config.home.is_locking || self.lock.exists {
            return Some((
                "cannot jog a locking indexer",
                "cannot jog joint {}: it is a locking indexer",
            ));
        }
        if self.config.home.sequence < 0 && !self.homing.homed {
            return Some((
                "cannot jog a joint that is homed together with others before it is homed",
                "cannot jog joint {} before it is homed: its home-sequence is below 0",
            ));
        }
        None
    }

    /// Returns whether a position is beyond a soft limit of a homed joint, by more than rounding.
    pub(crate) fn is_beyond(&self, pos: f64) -> bool {
        let c = &self.config;
        self.homing.homed && !(c.min_limit - SLACK <= pos && pos <= c.max_limit + SLACK)
    }

    /// Returns whether the joint is at or beyond its lower and its upper soft limit.
    pub(crate) fn at_soft_limits(&self) -> (bool, bool) {
        let [low, high] = self.inside;
        let homed = self.homing.homed;
        (homed & (self.pos_cmd <= low), homed & (high <= self.pos_cmd))
    }

    /// Sets the position of this cycle.
    pub(crate) fn place(&mut self, pos: f64, dt: f64) {
        let vel = (pos - self.pos_cmd) / dt;
        self.pos_cmd = pos;
        self.moving(vel, dt);
    }

    /// Sets position and velocity of this cycle from the joint's own planner. A velocity limit that was lowered during
    /// the motion applies: the joint brakes.
    pub(crate) fn place_free(&mut self, dt: f64) {
        self.free.slow_to(self.move_velocity);
        self.free.step(dt);
        self.pos_cmd = self.free.tp.pos;
        self.moving(self.free.tp.vel, dt);
    }

    fn moving(&mut self, vel: f64, dt: f64) {
        let acc = (vel - self.vel_cmd) / dt;
        self.jerk_cmd = (acc - self.acc_cmd) / dt;
        self.acc_cmd = acc;
        self.vel_cmd = vel;
    }

    /// Moves the correction of backlash or screw errors according to position and direction of movement.
    pub(crate) fn correct(&mut self, tables: &Tables, dt: f64, enabled: bool) {
        // The rounding of a position that is reached is no reversal.
        let by = self.pos_cmd - self.farthest;
        if !enabled {
            self.farthest = self.pos_cmd;
        } else if fabs(by) > SLACK {
            (self.forward, self.farthest) = (Some(by > 0.0), self.pos_cmd);
        } else if self.forward.is_some_and(|forward| forward == (by > 0.0)) {
            self.farthest = self.pos_cmd;
        }
        if is_zero([self.share, self.backlash_want, self.backlash.pos, self.backlash.vel]) {
            return;
        }
        let homed = self.homing.homed;
        self.backlash_want = tables.correction(&self.config, self.pos_cmd, homed, self.forward);
        if !enabled {
            self.backlash.vel = 0.0;
            return;
        }
        self.backlash.target = self.backlash_want;
        // A correction that was switched off leaves softly.
        let share = if self.share == 0.0 { DEFAULT_SHARE } else { self.share };
        self.backlash.max_vel = share * self.config.max_velocity;
        self.backlash.max_acc = share * self.config.max_acceleration;
        self.backlash.enable = true;
        self.backlash.step_exactly(dt);
    }

    /// Returns whether a closed lock keeps the joint from a position.
    pub(crate) fn is_held(&self, pos: f64) -> bool {
        self.active && !self.extra && self.lock.is_closed() && fabs(pos - self.pos_cmd) > LOCKED
    }

    /// Opens or closes the lock. It closes once the joint is at rest.
    pub(crate) fn work_lock(&mut self, enabled: bool) {
        let moves = enabled && (self.free.tp.active || self.vel_cmd != 0.0);
        self.lock.work(self.homing.needs_open_lock(), moves);
    }

    /// Sets the current position to `pos` without motion.
    pub(crate) fn rename(&mut self, pos: f64) {
        let shift = pos - self.pos_fb;
        if !shift.is_finite() {
            return;
        }
        self.pos_cmd += shift;
        self.pos_fb += shift;
        self.motor_offset -= shift;
        self.farthest += shift;
        self.free.tp.shift(shift);
    }

    /// Adds an offset to the encoder's reading from now on, without motion.
    pub(crate) fn offset(&mut self, offset: f64) {
        let pos = self.inputs.motor_pos_fb - self.backlash.pos + offset;
        if !pos.is_finite() {
            return;
        }
        self.motor_offset = -offset;
        self.watch.change_zero();
        self.farthest = pos;
        self.pos_cmd = pos;
        self.pos_fb = pos;
        self.free.tp.shift(pos - self.free.tp.pos);
        (self.free.tp.pos, self.free.tp.target) = (pos, pos);
    }

    /// Returns the motor command for the guard to check.
    pub(crate) fn command(&self, enabled: bool) -> MotorCommand {
        MotorCommand {
            position: self.pos_cmd + self.backlash.pos + self.motor_offset,
            offset: self.motor_offset,
            correction: self.backlash.pos,
            feedback: self.inputs.motor_pos_fb,
            max_velocity: self.config.max_velocity,
            is_on: enabled && self.active,
        }
    }

    /// Returns to the last command that was written, as the machine goes off.
    pub(crate) fn hold(&mut self) {
        self.step_guard.hold();
        let pos = self.step_guard.last() - self.backlash.pos - self.motor_offset;
        if pos.is_finite() {
            self.pos_cmd = pos;
        }
    }

    /// Writes the pins. Returns whether a state of the joint has changed: more than its motion.
    pub(crate) fn write_pins(&mut self, pins: &JointPins, enabled: bool) -> bool {
        if let Some(value) = self.homing.take_index_enable()
            && let Some(pins) = &pins.homing
        {
            pins.index_enable.set(value);
        }
        pins.motor_pos_cmd.set(self.step_guard.last());
        pins.pos_cmd.set(self.pos_cmd);
        pins.pos_fb.set(self.pos_fb);
        pins.vel_cmd.set(self.vel_cmd);
        pins.acc_cmd.set(self.acc_cmd);
        pins.jerk_cmd.set(self.jerk_cmd);
        pins.coarse_pos_cmd.set(self.pos_cmd);
        pins.f_error.set(self.ferror);
        pins.f_error_lim.set(self.ferror_limit);
        let (below, above) = self.at_soft_limits();
        let (tp, inputs) = (&self.free.tp, &self.inputs);
        let state = packed([
            enabled,
            self.active,
            self.error,
            self.was_ferrored,
            inputs.amp_fault,
            inputs.at_max,
            inputs.at_min,
            self.homing.homed,
            tp.active,
            tp.enable,
            below,
            above,
        ]);
        let by = u64::from(self.free.by as u8) << 16;
        let code = if self.homing.is_under_way() { self.homing.code() } else { 0 };
        let changed = self.shown.changes([
            state | by | u64::from(code.cast_unsigned()) << 32,
            self.motor_offset.to_bits(),
            self.backlash_want.to_bits(),
            self.backlash.pos.to_bits(),
            self.backlash.vel.to_bits(),
            tp.target.to_bits(),
            tp.max_vel.to_bits(),
        ]);
        if changed {
            self.write_state(pins, enabled);
        }
        changed
    }

    fn write_state(&self, pins: &JointPins, enabled: bool) {
        let tp = &self.free.tp;
        pins.motor_offset.set(self.motor_offset);
        pins.backlash_corr.set(self.backlash_want);
        pins.backlash_filt.set(self.backlash.pos);
        pins.backlash_vel.set(self.backlash.vel);
        pins.free_pos_cmd.set(tp.target);
        pins.free_vel_lim.set(tp.max_vel);
        pins.free_tp_enable.set(tp.enable);
        pins.active.set(self.active);
        pins.amp_enable_out.set(enabled && self.active);
        pins.error.set(self.error);
        pins.f_errored.set(self.was_ferrored);
        pins.faulted.set(self.active && self.inputs.amp_fault);
        if let Some(pins) = &pins.homing {
            pins.homed.set(self.homing.homed);
            pins.homing.set(self.homing.is_under_way());
            pins.home_state.set(self.homing.code());
        }
        pins.in_position.set(!tp.active);
        pins.pos_hard_limit.set(self.active && self.inputs.at_max);
        pins.neg_hard_limit.set(self.active && self.inputs.at_min);
        pins.kb_jog_active.set(self.free.by == By::Command);
        pins.wheel_jog_active.set(self.free.by == By::Wheel);
    }
}

/// Tolerance for rounding of a position, in machine units.
const SLACK: f64 = 1e-6;

/// Rounding of a position that is no motion of a locked joint, in machine units.
const LOCKED: f64 = 1e-9;

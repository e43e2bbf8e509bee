//! Realtime. The last check of a motor's command: no joint steps farther in one cycle than its
//! velocity limit allows.
//!
//! The guard knows positions only. It shares no code with the planners, the kinematics or homing,
//! so that an error in one of them cannot also be in the check. [`Joint::show`](crate::joint) writes
//! nothing to `motor-pos-cmd` but what [`StepGuard::put_out`] or [`StepGuard::hold`] left here.
//!
//! While the amplifier is on, these must hold in each cycle of `dt` seconds:
//!
//! - **The command without its correction** moves by at most `max-velocity · dt`. Where homing gives
//!   the position another name, position and offset change together and the motor's command stays.
//! - **At an encoder's index** the feedback itself may jump, and the command with it. A step in a
//!   cycle in which the offset changes is therefore also measured from the feedback of that cycle:
//!   a command to the place where the motor is moves nothing.
//! - **As the amplifier comes on** the step is measured from the feedback as well.
//! - **The command is finite.**
//! - **The correction** (backlash) moves by at most `max-velocity · dt`.
//! - **A limit that is lowered in motion** does not make a jump of what was allowed before: a step
//!   may be beyond the new limit as long as it is no longer than the one before. A machine that
//!   brakes, however slowly, passes; one that goes faster is stopped.
//!
//! The margin is for rounding alone: a millionth of what is allowed, and [`ROUNDING`] of the numbers
//! from which the step is computed.

use libm::fabs;

/// A part of the largest position: what rounding makes of sums and of kinematics.
const ROUNDING: f64 = 1e-12;

/// A part of the step that is allowed.
const MARGIN: f64 = 1e-6;

/// The command for one motor, in machine units and seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotorCommand {
    /// What goes to `motor-pos-cmd`.
    pub(crate) position: f64,
    /// The part of it that homing found.
    pub(crate) offset: f64,
    /// The part of it that corrects the mechanics.
    pub(crate) correction: f64,
    /// Where the motor is.
    pub(crate) feedback: f64,
    pub(crate) max_velocity: f64,
    /// The amplifier is on in this cycle.
    pub(crate) is_on: bool,
}

/// A step that is not put out: positions of the joint, without offset and correction; or of the
/// correction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Jump {
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// The longest step that would have passed.
    pub(crate) allowed: f64,
    pub(crate) is_of_correction: bool,
}

/// The last command of one motor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StepGuard {
    last: MotorCommand,
    /// The lengths of the last steps of command and correction, no longer than what was allowed
    /// then.
    last_steps: [f64; 2],
}

impl StepGuard {
    /// The command that was put out last.
    pub(crate) const fn last(&self) -> f64 {
        self.last.position
    }

    /// Judges a command; changes nothing.
    pub(crate) fn judge(&self, c: &MotorCommand, dt: f64) -> Result<(), Jump> {
        if !c.is_on {
            return Ok(());
        }
        let from = self.start(c);
        let (step, corrected) = self.steps(c, from);
        let [of_step, of_correction] = self.allowed(c, dt);
        let size = fabs(from) + fabs(c.position) + fabs(c.offset) + fabs(c.correction);
        // NaN is not within.
        let is_within =
            |step: f64, allowed: f64| fabs(step) <= allowed * (1.0 + MARGIN) + ROUNDING * size;
        if c.position.is_finite() && !is_within(corrected, of_correction)
            || !c.correction.is_finite()
        {
            return Err(Jump {
                from: self.last.correction,
                to: c.correction,
                allowed: of_correction,
                is_of_correction: true,
            });
        }
        let goes_to_feedback =
            || self.is_renamed(c) && is_within(self.steps(c, c.feedback).0, of_step);
        if c.position.is_finite() && (is_within(step, of_step) || goes_to_feedback()) {
            return Ok(());
        }
        Err(Jump {
            from: from - self.last.correction - c.offset,
            to: c.position - c.correction - c.offset,
            allowed: of_step,
            is_of_correction: false,
        })
    }

    /// Puts a command out that was judged, or one of a motor whose amplifier is off.
    pub(crate) fn put_out(&mut self, c: &MotorCommand, dt: f64) {
        if !c.position.is_finite() {
            return self.hold();
        }
        let (mut step, corrected) = self.steps(c, self.start(c));
        if self.is_renamed(c) {
            let other = self.steps(c, c.feedback).0;
            step = if fabs(other) < fabs(step) { other } else { step };
        }
        let [of_step, of_correction] = self.allowed(c, dt);
        self.last_steps = [less(fabs(step), of_step), less(fabs(corrected), of_correction)];
        self.last = *c;
    }

    /// Keeps the last command; the amplifier is off.
    pub(crate) const fn hold(&mut self) {
        self.last.is_on = false;
    }

    /// How far the command and its correction may go: as far as the velocity limit allows in a
    /// cycle, or as far as in the last one.
    fn allowed(&self, c: &MotorCommand, dt: f64) -> [f64; 2] {
        let limit = c.max_velocity * dt;
        self.last_steps.map(|last| if self.last.is_on && last > limit { last } else { limit })
    }

    /// The command from which a step is measured.
    const fn start(&self, c: &MotorCommand) -> f64 {
        if self.last.is_on { self.last.position } else { c.feedback }
    }

    /// Homing has found where the joint is.
    const fn is_renamed(&self, c: &MotorCommand) -> bool {
        c.offset.to_bits() != self.last.offset.to_bits()
    }

    /// The steps from there: of the command without its correction, and of the correction.
    fn steps(&self, c: &MotorCommand, from: f64) -> (f64, f64) {
        let corrected = c.correction - self.last.correction;
        (c.position - from - corrected, corrected)
    }
}

fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

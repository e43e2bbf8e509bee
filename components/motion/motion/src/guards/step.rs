//! Realtime. The last check of a motor's command: no joint steps farther in one cycle than its velocity limit allows.
//!
//! The guard knows positions only. It shares no code with the planners, the kinematics or homing, so that an error in
//! one of them cannot also be in the check. [`Joint::write_pins`](crate::joint) writes only values to `motor-pos-cmd` that
//! [`StepGuard::put_out`] or [`StepGuard::hold`] left here.
//!
//! While the amplifier is on, these must hold in each cycle of `dt` seconds:
//!
//! - **The command without its correction** moves by at most `max-velocity · dt`. When homing redefines the position,
//!   position and offset change together and the motor's command stays.
//! - **At an encoder's index** the feedback itself may jump, and the command with it. A step in a cycle in which the
//!   offset changes is therefore also measured from the feedback of that cycle: a command to the motor's own position
//!   moves nothing.
//! - **When the amplifier comes on** the step is measured from the feedback as well.
//! - **The command is finite.**
//! - **The correction** (backlash) moves by at most `max-velocity · dt`.
//! - **A limit that is lowered in motion** does not turn a previously permitted step into a jump: a step may exceed the
//!   new limit as long as it is no longer than the previous step. A machine that brakes, however slowly, passes; a
//!   machine that accelerates is stopped.
//!
//! The tolerance covers rounding alone: a millionth of the permitted step, and [`ROUNDING`] times the numbers from
//! which the step is computed.

use libm::fabs;

/// Rounding error of sums and of kinematics, relative to the largest position.
const ROUNDING: f64 = 1e-13;

/// Tolerance relative to the permitted step.
const MARGIN: f64 = 1e-6;

/// Command for one motor, in machine units and seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotorCommand {
    /// Value for `motor-pos-cmd`.
    pub(crate) position: f64,
    /// Part of the position that homing found.
    pub(crate) offset: f64,
    /// Part of the position that corrects the mechanics.
    pub(crate) correction: f64,
    /// Measured position of the motor.
    pub(crate) feedback: f64,
    pub(crate) max_velocity: f64,
    /// True if the amplifier is on in this cycle.
    pub(crate) is_on: bool,
}

/// A step that is not written: positions of the joint, without offset and correction, or positions of the correction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Jump {
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Length of the longest step that would have passed.
    pub(crate) allowed: f64,
    pub(crate) is_of_correction: bool,
}

/// Last command of one motor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StepGuard {
    last: MotorCommand,
    last_steps: Steps,
}

/// Lengths of the steps of command and correction, clamped to the lengths permitted at that time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Steps([f64; 2]);

impl StepGuard {
    /// Returns the command that was written last.
    pub(crate) const fn last(&self) -> f64 {
        self.last.position
    }

    /// Returns the last command with its parts.
    pub(crate) const fn command(&self) -> &MotorCommand {
        &self.last
    }

    /// Checks a command; changes nothing. Returns the lengths of its steps for [`Self::put_out`].
    #[inline]
    pub(crate) fn judge(&self, c: &MotorCommand, dt: f64) -> Result<Steps, Jump> {
        let from = self.start(c);
        let (mut step, corrected) = self.steps(c, from);
        let [of_step, of_correction] = self.allowed(c, dt);
        if c.is_on {
            let size = fabs(from) + fabs(c.position) + fabs(c.offset) + fabs(c.correction);
            // NaN fails the comparison.
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
            if !c.position.is_finite() || !is_within(step, of_step) && !goes_to_feedback() {
                return Err(Jump {
                    from: from - self.last.correction - c.offset,
                    to: c.position - c.correction - c.offset,
                    allowed: of_step,
                    is_of_correction: false,
                });
            }
        }
        if self.is_renamed(c) {
            let other = self.steps(c, c.feedback).0;
            step = if fabs(other) < fabs(step) { other } else { step };
        }
        Ok(Steps([less(fabs(step), of_step), less(fabs(corrected), of_correction)]))
    }

    /// Accepts a command that passed the check, or one for a motor whose amplifier is off.
    pub(crate) fn put_out(&mut self, c: &MotorCommand, steps: Steps) {
        if !c.position.is_finite() {
            return self.hold();
        }
        self.last_steps = steps;
        self.last = *c;
    }

    /// Keeps the last command; the amplifier is off.
    pub(crate) const fn hold(&mut self) {
        self.last.is_on = false;
    }

    /// Returns the permitted steps of the command and its correction: the distance at the velocity limit in a cycle, or
    /// the length of the last step if that is longer.
    fn allowed(&self, c: &MotorCommand, dt: f64) -> [f64; 2] {
        let limit = c.max_velocity * dt;
        self.last_steps.0.map(|last| if self.last.is_on && last > limit { last } else { limit })
    }

    /// Returns the command from which a step is measured.
    const fn start(&self, c: &MotorCommand) -> f64 {
        if self.last.is_on { self.last.position } else { c.feedback }
    }

    /// Returns whether homing has changed the offset.
    const fn is_renamed(&self, c: &MotorCommand) -> bool {
        c.offset.to_bits() != self.last.offset.to_bits()
    }

    /// Returns the steps from `from`: of the command without its correction, and of the correction.
    fn steps(&self, c: &MotorCommand, from: f64) -> (f64, f64) {
        let corrected = c.correction - self.last.correction;
        (c.position - from - corrected, corrected)
    }
}

fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_bench::Random;

    const DT: f64 = 1e-3;
    const ON: MotorCommand = MotorCommand {
        position: 0.0,
        offset: 0.0,
        correction: 0.0,
        feedback: 0.0,
        max_velocity: 100.0,
        is_on: true,
    };

    fn passes(guard: &mut StepGuard, c: MotorCommand) -> bool {
        let steps = guard.judge(&c, DT);
        if let Ok(steps) = steps {
            guard.put_out(&c, steps);
        }
        steps.is_ok()
    }

    #[test]
    fn the_margin_does_not_add_up() {
        let mut guard = StepGuard::default();
        let (mut position, mut step) = (0.0, 0.1);
        let mut passed = 0;
        for _ in 0..100 {
            position += step;
            step *= 1.0 + 0.6 * MARGIN;
            passed += usize::from(passes(&mut guard, MotorCommand { position, ..ON }));
        }
        // The first steps are within the tolerance, and the first one beyond it is never accepted.
        assert_eq!(passed, 2);
    }

    #[test]
    fn at_any_size_of_the_position() {
        for at in [0.0, 1e-6, 1.0, -1e6, 1e8] {
            let mut guard = StepGuard::default();
            let start = MotorCommand { position: at, feedback: at, ..ON };
            assert!(passes(&mut guard, start), "{at}");
            let near = MotorCommand { position: at + 0.1, ..start };
            assert!(guard.judge(&near, DT).is_ok(), "{at}");
            let far = MotorCommand { position: at + 0.102, ..start };
            let jump = guard.judge(&far, DT).unwrap_err();
            assert_eq!((jump.from, jump.to, jump.is_of_correction), (at, at + 0.102, false));
            assert_eq!(jump.allowed, 0.1);
        }
    }

    /// Each of the four numbers of a step may be rounded.
    #[test]
    fn the_tolerance_grows_with_each_number_and_a_jump_names_the_joints_own_places() {
        for (offset, correction) in [(1e7, 1e7), (-1e7, 1e7), (1e7, -1e7)] {
            let mut guard = StepGuard::default();
            let start = MotorCommand { position: 1e7, feedback: 1e7, offset, correction, ..ON };
            assert!(passes(&mut guard, MotorCommand { is_on: false, ..start }));
            assert!(passes(&mut guard, start));
            // A millionth of 0.1, and 1e-13 of four times 1e7.
            let within = MotorCommand { position: 1e7 + 0.1 + 3.8e-6, ..start };
            assert!(guard.judge(&within, DT).is_ok());
            let beyond = MotorCommand { position: 1e7 + 0.1 + 4.4e-6, ..start };
            let jump = guard.judge(&beyond, DT).unwrap_err();
            assert_eq!(jump.from, 1e7 - correction - offset);
            assert_eq!(jump.to, beyond.position - correction - offset);
        }
    }

    #[test]
    fn while_the_amplifier_is_off_everything_finite_passes() {
        let mut guard = StepGuard::default();
        for position in [3.0, -1e9, f64::NAN, f64::INFINITY, 7.0] {
            let last = guard.last();
            assert!(passes(&mut guard, MotorCommand { position, is_on: false, ..ON }));
            assert_eq!(guard.last(), if position.is_finite() { position } else { last });
        }
        // When switched on, it begins at the motor's position, whatever the last command was.
        let mut other = guard;
        assert!(!passes(&mut other, MotorCommand { position: 7.0, feedback: 8.0, ..ON }));
        assert!(passes(&mut guard, MotorCommand { position: 8.05, feedback: 8.0, ..ON }));
    }

    #[test]
    fn an_offset_changes_with_the_position_or_at_the_place_of_the_motor() {
        let mut guard = StepGuard::default();
        let start = MotorCommand { position: 50.0, feedback: 50.0, ..ON };
        assert!(passes(&mut guard, start));
        // Alone, it would move the motor.
        let alone = MotorCommand { position: 53.0, offset: 3.0, ..start };
        assert!(guard.judge(&alone, DT).is_err());
        let renamed = MotorCommand { offset: 3.0, ..start };
        assert!(guard.judge(&renamed, DT).is_ok());
        // The encoder's index has set the feedback to zero.
        let index = MotorCommand { position: 0.05, offset: 3.0, feedback: 0.0, ..start };
        assert!(guard.judge(&index, DT).is_ok());
        let beside = MotorCommand { position: 0.15, offset: 3.0, feedback: 0.0, ..start };
        assert!(guard.judge(&beside, DT).is_err());
        let no_index = MotorCommand { position: 0.05, feedback: 0.0, ..start };
        assert!(guard.judge(&no_index, DT).is_err());
    }

    /// Compares with a second implementation of the rules, for command sequences that no planner produces.
    #[test]
    fn random_commands() {
        let mut random = Random::new(7);
        let steps = [0.0, 0.05, -0.0999, 0.1, 0.1002, -0.3, 4.0, -1e6];
        let (mut passed, mut held) = (0, 0);
        for _ in 0..2000 {
            let mut guard = StepGuard::default();
            let mut last: Option<MotorCommand> = None;
            let [mut way, mut correction_way] = [0.0_f64; 2];
            for _ in 0..50 {
                let before = last.unwrap_or(ON);
                let mut c = before;
                c.position += random.pick(&steps);
                c.feedback = before.position + random.pick(&[0.0, 0.02, 5.0]);
                c.is_on = random.below(10) > 0;
                c.max_velocity = random.pick(&[100.0, 100.0, 100.0, 30.0, 1000.0]);
                if random.below(8) == 0 {
                    c.correction += random.pick(&[0.04, -0.2]);
                    c.position += c.correction - before.correction;
                }
                if random.below(8) == 0 {
                    c.offset += 1.5;
                }
                let was_on = last.is_some_and(|l| l.is_on);
                let start = if was_on { before.position } else { c.feedback };
                let limit = c.max_velocity * DT;
                let [allowed, allowed_correction] =
                    [way, correction_way].map(|w| if was_on { w.max(limit) } else { limit });
                let corrected = c.correction - before.correction;
                let step = (c.position - start - corrected).abs();
                let beside = (c.position - c.feedback - corrected).abs();
                let renamed = c.offset != before.offset;
                let nearest = if renamed { step.min(beside) } else { step };
                let legal = !c.is_on
                    || nearest < allowed * 1.0005 && corrected.abs() < allowed_correction * 1.0005;
                let steps = guard.judge(&c, DT);
                assert_eq!(steps.is_ok(), legal, "{before:?} {c:?}");
                let out = guard.last();
                if let Ok(steps) = steps {
                    guard.put_out(&c, steps);
                    assert_eq!(guard.last(), c.position);
                    way = nearest.min(allowed);
                    correction_way = corrected.abs().min(allowed_correction);
                    last = Some(c);
                    passed += 1;
                } else {
                    guard.hold();
                    assert_eq!(guard.last(), out);
                    last = last.map(|l| MotorCommand { is_on: false, ..l });
                    held += 1;
                }
            }
        }
        assert!(passed > 10_000 && held > 10_000, "{passed} {held}");
    }
}

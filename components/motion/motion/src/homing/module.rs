//! Realtime. Record of a joint for a homing module of a user, and the changes that the module may make to it.

use crate::{
    commands::{
        command::Joints,
        config::{Encoder, HomeConfig},
    },
    homing::{one_joint::move_to, texts::Texts},
    jogger::By,
    joint::Joint,
    setup::MAX_JOINTS,
};
use hal_component::{
    HomingRef, TicketHandle,
    abi::{HomingJoint, HomingSettings, homing_flags as flags},
};
use libm::fabs;

/// Homing by a module in the place of the controller's own.
#[derive(Debug)]
pub(crate) struct ModuleHoming {
    pub(crate) service: HomingRef,
    pub(crate) texts: Texts,
    joints: [Exchange; MAX_JOINTS],
    /// Joints that the module may call homed while they are not: homing failed or was aborted.
    pub(crate) distrusted: Joints,
    pub(crate) request: Option<Request>,
    /// True if the module has had the records of this cycle, and may have changed them.
    pub(crate) has_records: bool,
}

/// A command to home joints that is in progress.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) set: Joints,
    /// Joints of the set that the module has not begun to home.
    pub(crate) waiting: Joints,
    pub(crate) ticket: TicketHandle,
    /// True once the module has run a cycle for it.
    pub(crate) has_run: bool,
    /// Time for which the module has homed nothing, in seconds.
    pub(crate) quiet: f64,
}

/// Last record of a joint, the module's last target, and its last settings.
#[derive(Clone, Copy, Debug, Default)]
struct Exchange {
    sent: HomingJoint,
    target: f64,
    settings: Option<HomeConfig>,
}

/// Reason why a module may not home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ModuleError {
    /// A number that it wrote is NaN or infinite.
    NotFinite,
    /// Positions and offset do not change together, or the velocity is below 0.
    Inconsistent,
    /// A joint moves without a command to home.
    Unasked,
}

impl ModuleError {
    /// Returns the text for tickets and for the causes of stops.
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::NotFinite => "the homing module wrote a number that is not finite",
            Self::Inconsistent => "the homing module would have made a joint jump",
            Self::Unasked => "the homing module moved a joint without motion.home",
        }
    }

    /// Returns the message for the operator; its number is that of the joint.
    pub(crate) const fn say(self, texts: &Texts) -> &'static str {
        match self {
            Self::NotFinite => texts.not_finite,
            Self::Inconsistent => texts.inconsistent,
            Self::Unasked => texts.unasked,
        }
    }
}

impl ModuleHoming {
    pub(crate) fn new(service: HomingRef) -> Self {
        Self {
            texts: Texts::new(service.name()),
            service,
            joints: [Exchange::default(); MAX_JOINTS],
            distrusted: 0,
            request: None,
            has_records: false,
        }
    }

    /// Writes the records of all joints.
    pub(crate) fn put(&mut self, joints: &[Joint], enabled: bool) {
        for (n, (joint, own)) in joints.iter().zip(&mut self.joints).enumerate() {
            own.sent = record(joint, enabled, own.target);
            self.service.put(n, &own.sent);
        }
    }

    /// Takes over what the module has changed of a joint. `may`: the joint takes part in a command to home.
    pub(crate) fn take(
        &mut self,
        n: usize,
        joint: &mut Joint,
        may: bool,
    ) -> Result<(), ModuleError> {
        let Some(own) = self.joints.get_mut(n) else { return Ok(()) };
        let mut left = own.sent;
        self.service.take(n, &mut left);
        let drives = take_over(joint, &own.sent, &left, may)?;
        if drives {
            own.target = left.target;
        }
        Ok(())
    }

    /// Passes on the settings of a joint, if they have changed.
    pub(crate) fn configure(&mut self, n: usize, config: &HomeConfig) {
        let Some(own) = self.joints.get_mut(n) else { return };
        let before = own.settings.replace(*config);
        if before == Some(*config) {
            return;
        }
        let HomeConfig { place, offset, sequence, .. } = *config;
        let is_update =
            before.is_some_and(|c| HomeConfig { place, offset, sequence, ..c } == *config);
        self.service.configure(n, &settings(config), is_update);
    }
}

fn record(joint: &Joint, enabled: bool, target: f64) -> HomingJoint {
    let (c, tp, jog) = (&joint.config, &joint.free.tp, joint.jog_limits());
    let is_driven = joint.free.by == By::Homing && tp.enable;
    let bits = [
        (enabled && joint.active, flags::ENABLED),
        (joint.active, flags::ACTIVE),
        (!tp.active, flags::IN_POSITION),
        (joint.error, flags::ERROR),
        (joint.inputs.at_max, flags::AT_MAX),
        (joint.inputs.at_min, flags::AT_MIN),
        (joint.was_ferrored, flags::FERROR),
        (joint.inputs.amp_fault, flags::FAULT),
        (joint.lock.exists, flags::HAS_LOCK),
        (joint.lock.exists && joint.lock.is_open, flags::UNLOCKED),
        (joint.free.by == By::Command, flags::KB_JOG),
        (joint.free.by == By::Wheel, flags::WHEEL_JOG),
        (tp.enable, flags::PLANNER_ON),
        (tp.active, flags::PLANNER_ACTIVE),
    ];
    HomingJoint {
        size: hal_component::abi::size::<HomingJoint>(),
        flags: bits.iter().filter(|(is, _)| *is).fold(0, |bits, (_, bit)| bits | bit),
        max_limit: c.max_limit,
        min_limit: c.min_limit,
        max_jog: jog.max,
        min_jog: jog.min,
        max_velocity: joint.move_velocity,
        max_acceleration: c.move_acceleration(),
        min_ferror: c.min_ferror.unwrap_or(c.ferror),
        max_ferror: c.ferror,
        backlash: c.backlash,
        pos_cmd: joint.pos_cmd,
        vel_cmd: joint.vel_cmd,
        acc_cmd: joint.acc_cmd,
        backlash_corr: joint.backlash_want,
        backlash_filt: joint.backlash.pos,
        backlash_vel: joint.backlash.vel,
        motor_pos_cmd: joint.step_guard.last(),
        motor_pos_fb: joint.inputs.motor_pos_fb,
        pos_fb: joint.pos_fb,
        ferror: joint.ferror,
        ferror_limit: joint.ferror_limit,
        motor_offset: joint.motor_offset,
        target: if is_driven { target } else { tp.target },
        planner_velocity: tp.max_vel,
        planner_acceleration: c.move_acceleration(),
        planner_pos: tp.pos,
        planner_vel: tp.vel,
    }
}

/// Way in which a module has renamed the position of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Renaming {
    /// Not at all.
    None,
    /// Command, feedback and offset by the same distance: the motor's command stays.
    Shift,
    /// The command is the feedback with another offset: the motor's command is its measured position.
    ToFeedback,
}

/// Takes over what a module has changed. Returns whether it drives the planner.
fn take_over(
    joint: &mut Joint,
    sent: &HomingJoint,
    left: &HomingJoint,
    may: bool,
) -> Result<bool, ModuleError> {
    let is_on = left.flags & flags::PLANNER_ON != 0;
    let was_on = sent.flags & flags::PLANNER_ON != 0;
    let is_new = |new: f64, old: f64| new.to_bits() != old.to_bits();
    let changes = [
        (left.pos_cmd, sent.pos_cmd),
        (left.pos_fb, sent.pos_fb),
        (left.motor_offset, sent.motor_offset),
        (left.planner_pos, sent.planner_pos),
        (left.target, sent.target),
        (left.planner_velocity, sent.planner_velocity),
    ];
    if changes.iter().any(|(new, old)| is_new(*new, *old) && !new.is_finite()) {
        return Err(ModuleError::NotFinite);
    }
    if is_new(left.planner_velocity, sent.planner_velocity) && left.planner_velocity < 0.0 {
        return Err(ModuleError::Inconsistent);
    }
    let renaming = renaming(sent, left).ok_or(ModuleError::Inconsistent)?;
    let is_renamed = renaming != Renaming::None;
    let is_other =
        is_new(left.target, sent.target) || is_new(left.planner_velocity, sent.planner_velocity);
    let drives = is_on && (!was_on || is_other);
    if (is_renamed || drives) && !may {
        return Err(ModuleError::Unasked);
    }
    match renaming {
        Renaming::None => {}
        Renaming::Shift => joint.rename(left.pos_fb),
        Renaming::ToFeedback => joint.offset(-left.motor_offset),
    }
    let is_homed_by_it = joint.free.by == By::Homing;
    if drives || is_on && is_renamed && is_homed_by_it {
        let target = bounded(joint, left.target);
        move_to(joint, target, left.planner_velocity);
        return Ok(true);
    }
    if was_on && !is_on && (may || is_homed_by_it) {
        joint.free.brake();
    }
    Ok(false)
}

/// Returns how positions and offset have changed; `None` if that would make the joint jump.
fn renaming(sent: &HomingJoint, left: &HomingJoint) -> Option<Renaming> {
    let offset = left.motor_offset - sent.motor_offset;
    let shift = left.pos_cmd - sent.pos_cmd;
    let measured = left.pos_fb - sent.pos_fb;
    let planned = left.planner_pos - sent.planner_pos;
    if is_unchanged([offset, shift, measured, planned]) {
        return Some(Renaming::None);
    }
    // Beyond it a sum of positions would lose more than the step of a joint.
    if fabs(left.pos_cmd) > LARGEST || fabs(left.motor_offset) > LARGEST {
        return None;
    }
    let near = |a: f64, b: f64| {
        let size = fabs(sent.pos_cmd) + fabs(left.pos_cmd) + fabs(left.motor_offset);
        fabs(a - b) <= ROUNDING * (1.0 + size)
    };
    if !near(planned, shift) {
        return None;
    }
    if near(shift, -offset) && near(measured, -offset) {
        return Some(Renaming::Shift);
    }
    let feedback = left.motor_pos_fb - left.backlash_filt - left.motor_offset;
    let is_there = near(left.pos_fb, feedback) && near(left.pos_cmd, left.pos_fb);
    is_there.then_some(Renaming::ToFeedback)
}

fn is_unchanged(changes: [f64; 4]) -> bool {
    // NaN stays NaN where there is no feedback.
    changes.iter().all(|c| *c == 0.0 || c.is_nan())
}

/// Limits a target to twice the distance between the limits, from where the joint stands.
fn bounded(joint: &Joint, target: f64) -> f64 {
    let most = 2.0 * (joint.config.max_limit - joint.config.min_limit);
    let at = joint.free.tp.pos;
    if target - at > most {
        at + most
    } else if target - at < -most {
        at - most
    } else {
        target
    }
}

fn settings(c: &HomeConfig) -> HomingSettings {
    let is_absolute = matches!(c.encoder, Encoder::Absolute | Encoder::AbsoluteStill);
    let bits = [
        (c.ignore_limits, 1),
        (c.use_index, 2),
        (c.is_shared, 4),
        (c.is_locking, 8),
        (is_absolute, 16 | 32),
        (c.encoder == Encoder::AbsoluteStill, 64),
        (c.encoder == Encoder::Goes, 128),
    ];
    HomingSettings {
        size: hal_component::abi::size::<HomingSettings>(),
        flags: bits.iter().filter(|(is, _)| *is).fold(0, |bits, (_, bit)| bits | bit),
        sequence: c.sequence,
        volatile_home: u32::from(c.is_volatile),
        offset: c.offset,
        home: c.place,
        final_velocity: c.final_vel,
        search_velocity: c.search_vel,
        latch_velocity: c.latch_vel,
    }
}

/// Rounding of positions that change together, relative to their size and in units.
const ROUNDING: f64 = 1e-9;

/// Largest position and offset that a module may give a joint, in units.
const LARGEST: f64 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;

    /// Joint at 10, measured at 9.5, whose motor reads 12.
    fn sent() -> HomingJoint {
        HomingJoint {
            pos_cmd: 10.0,
            pos_fb: 9.5,
            motor_offset: 2.4,
            backlash_filt: 0.1,
            motor_pos_fb: 12.0,
            planner_pos: 10.0,
            ..HomingJoint::default()
        }
    }

    #[test]
    fn a_renaming_leaves_the_motor_or_goes_to_its_feedback() {
        let sent = sent();
        for ([cmd, fb, offset, planner], expected) in [
            ([0.0, 0.0, 0.0, 0.0], Some(Renaming::None)),
            ([3.0, 3.0, -3.0, 3.0], Some(Renaming::Shift)),
            ([-1e6, -1e6, 1e6, -1e6], Some(Renaming::Shift)),
            // The command becomes the feedback with another offset.
            ([-1.5, -1.0, 1.0, -1.5], Some(Renaming::ToFeedback)),
            ([-1.0, -1.0, 1.0, -1.0], Some(Renaming::Shift)),
            // With the offset of the last time: the command alone, by the following error.
            ([-0.5, 0.0, 0.0, -0.5], Some(Renaming::ToFeedback)),
            // Every part by itself, or by another distance.
            ([3.0, 0.0, 0.0, 0.0], None),
            ([0.0, 3.0, 0.0, 0.0], None),
            ([0.0, 0.0, -3.0, 0.0], None),
            ([0.0, 0.0, 0.0, 3.0], None),
            ([3.0, 3.0, -3.0, 0.0], None),
            ([3.0, 3.0, -2.9, 3.0], None),
            ([3.0, 2.9, -3.0, 3.0], None),
            ([1e18, 1e18, -1e18, 1e18], None),
            ([-1.5, -1.1, 1.0, -1.5], None),
            ([3.0, f64::NAN, -3.0, 3.0], None),
        ] {
            let left = HomingJoint {
                pos_cmd: sent.pos_cmd + cmd,
                pos_fb: sent.pos_fb + fb,
                motor_offset: sent.motor_offset + offset,
                planner_pos: sent.planner_pos + planner,
                ..sent
            };
            assert_eq!(renaming(&sent, &left), expected, "{cmd} {fb} {offset} {planner}");
        }
        let unmeasured = HomingJoint { pos_fb: f64::NAN, ..sent };
        assert_eq!(renaming(&unmeasured, &unmeasured), Some(Renaming::None));
    }
}

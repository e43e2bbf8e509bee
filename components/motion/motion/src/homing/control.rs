//! Realtime. Homing of the machine: when joints may be homed or unhomed, and what ends it.

use crate::{
    commands::command::{Joints, Mode},
    commands::refusal::Refusal,
    homing::error::HomingError,
    homing::sequence::{HomingSequence, Progress, check, has, with_partners},
    state::State,
};
use hal_component::TicketHandle;

impl State {
    /// Begins to home joints; the ticket is done when all are homed.
    pub(crate) fn home(&mut self, set: Joints, ticket: TicketHandle) -> Result<(), Refusal> {
        self.needs_enabled("cannot home: the machine is not enabled")?;
        if self.inputs.homing_inhibit {
            return Err(Refusal::new("homing denied by motion.homing-inhibit"));
        }
        if self.homing.is_some() || self.is_module_asked() {
            return Err(Refusal::new("cannot home: homing is under way"));
        }
        let asked = self.wanted(set)?;
        if self.module.is_some() {
            self.set_mode(Mode::Free)?;
            self.home_by_module(asked, set == Joints::MAX, ticket);
            return Ok(());
        }
        let set = with_partners(&self.joints, asked);
        check(&self.joints, set)?;
        self.set_mode(Mode::Free)?;
        self.homing = Some(HomingSequence::begin(&mut self.joints, set, ticket));
        Ok(())
    }

    /// Runs one cycle of all joints that are being homed.
    pub(crate) fn homing_cycle(&mut self, dt: f64) {
        if self.module.is_some() {
            return self.module_cycle(dt);
        }
        let Some(sequence) = &mut self.homing else { return };
        match sequence.cycle(&mut self.joints, dt) {
            Progress::UnderWay => {}
            Progress::Done => {
                if let Some(sequence) = self.homing.take() {
                    sequence.done();
                }
            }
            Progress::Failed(n, why) => self.fail_homing(n, why),
        }
    }

    /// Aborts homing because a joint cannot be homed.
    pub(crate) fn fail_homing(&mut self, n: usize, why: HomingError) {
        let code = self.joints.get(n).map_or(0, |j| j.homing.code());
        self.say.error(why.say(), &[n as f64, f64::from(code)]);
        self.stops.keep(self.now_ns, why.text());
        self.end_homing(why.text());
    }

    /// Aborts homing, and brakes.
    pub(crate) fn end_homing(&mut self, why: &'static str) {
        self.cancel_module(why);
        for joint in self.joints.iter_mut().filter(|j| j.homing.is_under_way()) {
            joint.homing.abort();
            joint.free.stop(why, None);
        }
        if let Some(sequence) = self.homing.take() {
            sequence.fail(why);
        }
    }

    pub(crate) fn unhome(&mut self, set: Joints) -> Result<(), Refusal> {
        let set = self.wanted(set)?;
        if !self.is_idle() {
            return Err(Refusal::new("cannot unhome while the machine moves"));
        }
        if self.enabled {
            self.set_mode(Mode::Free)?;
        }
        self.unhome_by_module(set)?;
        for (n, joint) in self.joints.iter_mut().enumerate() {
            if has(set, n) {
                joint.homing.homed = false;
            }
        }
        Ok(())
    }
}

//! Realtime. Homing of the machine: when joints may be homed or unhomed, and what ends it.

use crate::{
    commands::command::Joints,
    commands::refusal::Refusal,
    homing::error::HomingError,
    homing::sequence::{HomingSequence, Progress, has, with_partners},
    state::State,
};
use hal_component::TicketHandle;
use hal_safety::Event;

impl State {
    /// Begins to home joints, of which the safety machine has agreed; the ticket is done when all are homed.
    pub(crate) fn home(&mut self, set: Joints, ticket: TicketHandle) {
        // It was checked as the request was.
        let Ok(asked) = self.wanted(set) else { return };
        if self.module.is_some() {
            return self.home_by_module(asked, set == Joints::MAX, ticket);
        }
        let set = with_partners(&self.joints, asked);
        self.homing = Some(HomingSequence::begin(&mut self.joints, set, ticket));
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
        self.tell(Event::HomingFailed, why.text());
        if why == HomingError::Limit {
            // The switch is no longer one of homing.
            self.guard_joints();
        }
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
        self.unhome_by_module(set)?;
        for (n, joint) in self.joints.iter_mut().enumerate() {
            if has(set, n) {
                joint.homing.homed = false;
            }
        }
        Ok(())
    }
}

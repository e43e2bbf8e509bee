//! Realtime. Causes that switch the machine off, by a drop or by a ramp.

use crate::{
    guards::interlock::Lockout,
    names::{JointText, joint_text},
    pins::Pins,
    state::State,
};
use hal_safety::{Answer, Event, Stop, Trouble};

static ON_SWITCH: JointText = joint_text!("", " on limit switch error");
static AMPLIFIER: JointText = joint_text!("", " amplifier fault");
static FOLLOWING: JointText = joint_text!("", " following error");

/// Causes of this cycle: the first one that stops something, and the strongest stop.
#[derive(Default)]
struct FoundCauses {
    cause: Option<&'static str>,
    answer: Answer,
    /// True if the joints braked after a fault before: soft faults were told then.
    was_stopping: bool,
}

impl State {
    /// Checks every cause to switch off; completes the ticket of the enable command.
    pub(crate) fn guard(&mut self, pins: &Pins) {
        if self.is_on() {
            let mut found = self.no_causes();
            self.judge_machine(pins, &mut found);
            let is_troubled = |j: &crate::joint::Joint| {
                let inputs = &j.inputs;
                inputs.at_max | inputs.at_min | inputs.amp_fault | j.was_ferrored
            };
            if self.joints.iter().any(is_troubled) {
                self.judge_joints(&mut found);
            }
            for (n, _) in pins.lists.misc_errors.iter().enumerate().filter(|(_, e)| e.get()) {
                self.say.error("Motion Stopped by misc error {}", &[n as f64]);
                self.find(&mut found, Trouble::Hard, "motion stopped by misc error");
            }
            self.stop_for_causes(&found);
        }
        if let Some(ticket) = self.enable_ticket.take() {
            ticket.done();
        }
    }

    /// Checks the causes that joints have to switch off, once more in a cycle.
    pub(crate) fn guard_joints(&mut self) {
        let mut found = self.no_causes();
        self.judge_joints(&mut found);
        self.stop_for_causes(&found);
    }

    fn no_causes(&self) -> FoundCauses {
        FoundCauses { was_stopping: self.is_stopping(), ..FoundCauses::default() }
    }

    fn stop_for_causes(&mut self, found: &FoundCauses) {
        if let Some(cause) = found.cause {
            self.stops.keep(self.now_ns, cause);
            self.obey(&found.answer, cause);
        }
    }

    /// Reports an e-stop, a missing enable input, and faults of spindles.
    fn judge_machine(&mut self, pins: &Pins, found: &mut FoundCauses) {
        if let Some(lockout) = self.inputs.lockout {
            match lockout {
                // What somebody has commanded is no error.
                Lockout::Commanded => self.say.notice(lockout.cause(), &[]),
                Lockout::Open | Lockout::Hardware => self.say.error(lockout.cause(), &[]),
            }
            self.find(found, Trouble::Hard, lockout.cause());
        } else if !self.inputs.enable {
            self.say.error("motion stopped by enable input", &[]);
            self.find(found, Trouble::Hard, "motion stopped by enable input");
        }
        for (n, _) in pins.spindles.iter().enumerate().filter(|(_, s)| s.amp_fault_in.get()) {
            self.say.error("spindle {} amplifier fault", &[n as f64]);
            self.find(found, Trouble::Hard, "spindle amplifier fault");
        }
    }

    /// Reports joints on switches, with faults, or with following errors.
    fn judge_joints(&mut self, found: &mut FoundCauses) {
        for n in 0..self.joints.len() {
            let Some(joint) = self.joints.get(n).filter(|j| j.active) else { continue };
            let on_switch = joint.inputs.at_max || joint.inputs.at_min;
            let (by, has_fault) = (joint.config.fault_stop, joint.inputs.amp_fault);
            if on_switch && !self.overriding && !joint.homing.has_limits() {
                self.trip(found, n, Trouble::Limit(by), &ON_SWITCH, "joint on limit switch error");
            }
            if has_fault {
                self.trip(found, n, Trouble::Hard, &AMPLIFIER, "joint amplifier fault");
            }
        }
        for n in 0..self.joints.len() {
            let Some(joint) = self.joints.get(n).filter(|j| j.is_ferrored()) else { continue };
            let error = libm::fabs(joint.ferror);
            let twice = error.is_nan() || error >= 2.0 * joint.ferror_limit;
            let trouble = Trouble::Following { by: joint.config.fault_stop, twice };
            self.trip(found, n, trouble, &FOLLOWING, "joint following error");
        }
    }

    /// Reports the trouble of a joint, once in a ramp, and lets the safety machine decide.
    fn trip(
        &mut self,
        found: &mut FoundCauses,
        n: usize,
        trouble: Trouble,
        say: &'static JointText,
        cause: &'static str,
    ) {
        let Some(joint) = self.joints.get_mut(n) else { return };
        let was_told = core::mem::replace(&mut joint.error, true);
        let stop = self.find(found, trouble, cause);
        if !(found.was_stopping && was_told && stop == Stop::None) {
            self.names.error(&self.say, say, n, &[]);
        }
    }

    /// Lets the safety machine decide on a trouble; keeps the first cause and the strongest stop.
    fn find(&mut self, found: &mut FoundCauses, trouble: Trouble, cause: &'static str) -> Stop {
        let facts = self.facts();
        let answer = self.machine.on(Event::Trouble(trouble), &facts);
        if answer.stop > Stop::None {
            found.cause.get_or_insert(cause);
        }
        if answer.stop > found.answer.stop {
            found.answer = answer;
        }
        answer.stop
    }

    /// Switches the machine off at once for a cause that is kept.
    pub(crate) fn stop_for(&mut self, cause: &'static str) {
        self.stops.keep(self.now_ns, cause);
        self.tell(Event::Trouble(Trouble::Hard), cause);
    }
}

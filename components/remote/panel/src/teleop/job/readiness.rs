//! Readiness of the machine for a job, checked before a start and again and again until the job has begun.

use super::number;
use crate::{engine::STOPPED, status::Machine};
use serde_json::Value as Json;
use teleop::{Code, Reason};

/// State of the task's status while the machine is on.
const ON: u64 = 2;
/// State of the task's status in e-stop.
const ESTOP: u64 = 0;

/// State on which a start depends, at one moment.
#[derive(Clone, Debug)]
pub(super) struct Readiness<'a> {
    /// Sentence about somebody else who has the control lease.
    pub(super) leased: Option<String>,
    /// The machine permits remote motion.
    pub(super) is_allowed: bool,
    /// Something was stopped since the start was asked for.
    pub(super) is_stopped: bool,
    /// No job runs before all joints are homed.
    pub(super) needs_homing: bool,
    pub(super) machine: &'a Machine,
}

impl Readiness<'_> {
    /// Returns why no job begins. Until a stop has ended, the task is not idle, although no other job runs: the stop is reported.
    pub(super) fn refusal(&self) -> Option<Reason> {
        let ocupado = |text: &str| Some(Reason::new(Code::Ocupado, text));
        if let Some(text) = &self.leased {
            return ocupado(text);
        }
        if let Some(text) = self.busy().filter(|_| self.state() == Some(ON) && !self.is_stopped) {
            return ocupado(text);
        }
        if let Some(text) = self.off() {
            return Some(Reason::new(Code::Apagado, text));
        }
        if self.is_stopped {
            return ocupado(STOPPED);
        }
        Some(Reason::new(Code::SinAjuste, self.unhomed()?))
    }

    /// Returns the state of the task.
    fn state(&self) -> Option<u64> {
        self.machine.task.as_ref().map(|task| number(task, "state"))
    }

    /// Returns why the machine is off.
    fn off(&self) -> Option<&'static str> {
        if !self.is_allowed {
            return Some("remote.allow-motion is FALSE: the machine permits no remote motion");
        }
        match self.state().filter(|_| self.machine.motion.is_some()) {
            Some(ON) => None,
            Some(ESTOP) => Some("the machine is in e-stop"),
            Some(_) => Some("the machine is off"),
            None => Some("the machine has no task controller"),
        }
    }

    /// Returns what the machine does.
    fn busy(&self) -> Option<&'static str> {
        if self.machine.task.as_ref().is_some_and(|task| number(task, "interpreter") != 0) {
            return Some("another job runs");
        }
        let motion = self.machine.motion.as_ref()?;
        let flag = |name: &str| motion.get(name) == Some(&Json::Bool(true));
        (flag("jogging") || flag("homing")).then_some("somebody moves the machine")
    }

    /// Returns which joint is not homed, if that is needed.
    fn unhomed(&self) -> Option<String> {
        let motion = self.machine.motion.as_ref()?;
        if !self.needs_homing || motion.get("all_homed") == Some(&Json::Bool(true)) {
            return None;
        }
        let is = |name: &str, n: usize| motion.get(name)?.get(n)?.as_bool();
        let joint = (0..16)
            .find(|n| is("joint_active", *n) == Some(true) && is("joint_homed", *n) == Some(false));
        Some(match joint {
            Some(n) => format!("joint {n} is not homed"),
            None => "a joint is not homed".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Map, json};

    fn map(json: Json) -> Option<Map<String, Json>> {
        json.as_object().cloned()
    }

    /// Every state of the machine with every other reason: the first one that is so is reported, in this order, and what
    /// the machine does is reported only if nothing has stopped it.
    #[test]
    fn what_has_stopped_a_start_is_reported_and_not_what_the_machine_does_because_of_it() {
        let stopped = format!("OCUPADO {STOPPED}");
        let told = [
            "OCUPADO another holds the lease",
            "OCUPADO another job runs",
            "OCUPADO somebody moves the machine",
            "OCUPADO somebody moves the machine",
            "APAGADO remote.allow-motion is FALSE: the machine permits no remote motion",
            "APAGADO the machine has no task controller",
            "APAGADO the machine is in e-stop",
            "APAGADO the machine is off",
            &stopped,
            "SIN_AJUSTE joint 1 is not homed",
        ];
        for set in 0..1_u32 << told.len() {
            let is = |n: usize| set >> n & 1 == 1;
            let state = if is(6) { 0 } else { [2, 1][usize::from(is(7))] };
            let interpreter = if is(1) { 1 + set % 3 } else { 0 };
            let task = map(json!({ "state": state, "interpreter": interpreter }));
            let motion = map(json!({
                "jogging": is(2), "homing": is(3), "all_homed": !is(9),
                "joint_active": [true, true, false], "joint_homed": [true, !is(9), false],
            }));
            let machine = Machine { task: task.filter(|_| !is(5)), motion, ..Machine::default() };
            let at = |needs_homing| Readiness {
                leased: is(0).then(|| "another holds the lease".to_owned()),
                is_allowed: !is(4),
                is_stopped: is(8),
                needs_homing,
                machine: &machine,
            };
            let runs = (5..9).all(|n| !is(n));
            let counts = |n: &usize| is(*n) && (runs || !(1..4).contains(n));
            let want = (0..told.len()).find(counts).map(|n| told[n].to_owned());
            let got = at(true).refusal();
            let got = got.map(|r| format!("{} {}", r.code.unwrap().text(), r.text));
            assert_eq!(got, want, "{set:#b}");
            assert_eq!(at(false).refusal().is_none(), set & !(1 << 9) == 0, "{set:#b}");
        }
    }
}

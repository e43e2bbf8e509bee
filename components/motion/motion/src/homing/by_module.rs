//! Realtime. Homing of the machine by a module of the user: calls of the module, and what follows from its answers.

use crate::{
    commands::{
        command::{Joints, Mode},
        refusal::Refusal,
    },
    homing::{
        error::HomingError,
        module::{ModuleError, Request},
        one_joint::is_at_limit,
        sequence::has,
    },
    jogger::By,
    state::State,
};
use hal_component::{TicketHandle, abi::homing_call};
use hal_safety::Event;

/// Time in which a module must begin to home a joint, in seconds.
const TIMEOUT: f64 = 1.0;

/// Result of a cycle of the module.
enum Ended {
    No,
    Done,
    /// A joint was not homed.
    Unfinished(usize),
    Failed(usize, HomingError),
    Wrong(usize, ModuleError),
}

impl State {
    /// Returns whether a command to home joints by the module is in progress.
    pub(crate) fn is_module_asked(&self) -> bool {
        self.module.as_ref().is_some_and(|m| m.request.is_some())
    }

    /// Has the module read its pins, before the joints are measured.
    pub(crate) fn read_module_pins(&mut self) {
        let Some(module) = &mut self.module else { return };
        module.service.call(homing_call::READ_PINS, 0);
        for (n, joint) in self.joints.iter_mut().enumerate() {
            if joint.homing.is_module_at_work() {
                let (waits, is_pending) = module.service.state(n).index();
                joint.homing.work_by_module(waits && !is_pending);
            }
        }
    }

    /// Has the module write its pins, after the joints.
    pub(crate) fn write_module_pins(&mut self) {
        let Some(module) = &mut self.module else { return };
        module.put(&self.joints, self.machine.is_on());
        module.service.call(homing_call::WRITE_PINS, 0);
    }

    /// Passes the settings of a joint to the module.
    pub(crate) fn configure_module(&mut self, n: usize) {
        if let (Some(module), Some(joint)) = (&mut self.module, self.joints.get(n)) {
            module.configure(n, &joint.config.home);
        }
    }

    /// Has the module home joints; the ticket is done when all are homed. `is_all`: all joints are meant.
    pub(crate) fn home_by_module(&mut self, set: Joints, is_all: bool, ticket: TicketHandle) {
        let Some(module) = &mut self.module else { return };
        for (_, joint) in self.joints.iter_mut().enumerate().filter(|(n, _)| has(set, *n)) {
            joint.free.stop("homing began", None);
            joint.homing.await_module();
        }
        module.request = Some(Request { set, waiting: set, ticket, has_run: false, quiet: 0.0 });
        module.put(&self.joints, self.machine.is_on());
        module.has_records = true;
        if is_all {
            module.service.call(homing_call::HOME, -1);
        } else {
            each(set, |n| {
                module.service.call(homing_call::HOME, n);
            });
        }
    }

    /// Runs one cycle of the module, in free mode while the machine is on.
    pub(crate) fn module_cycle(&mut self, dt: f64) {
        let ended = self.run_module(dt);
        match ended {
            Ended::No => {}
            Ended::Done => {
                if let Some(request) = self.module.as_mut().and_then(|m| m.request.take()) {
                    request.ticket.done();
                }
            }
            Ended::Unfinished(n) => {
                let text = self.module.as_ref().map_or("", |m| m.texts.unfinished);
                self.say.error(text, &[n as f64]);
                self.stops.keep(self.now_ns, UNFINISHED);
                self.tell(Event::HomingFailed, UNFINISHED);
            }
            Ended::Failed(n, why) => self.fail_homing(n, why),
            Ended::Wrong(n, why) => {
                let text = self.module.as_ref().map_or("", |m| why.say(&m.texts));
                self.say.error(text, &[n as f64]);
                if let Some(joint) = self.joints.get_mut(n) {
                    joint.error = true;
                    joint.homing.homed = false;
                }
                if let Some(module) = &mut self.module {
                    module.distrusted |= 1 << n;
                    module.distrusted |= module.request.as_ref().map_or(0, |r| r.set);
                }
                self.stop_for(why.text());
                if let Some(module) = &mut self.module {
                    module.put(&self.joints, false);
                    module.service.call(homing_call::UNHOME_OFF, number(n));
                }
            }
        }
    }

    fn run_module(&mut self, dt: f64) -> Ended {
        let Some(module) = &mut self.module else { return Ended::No };
        let runs = self.machine.is_on() && self.machine.mode() == Mode::Free;
        let is_asked = module.request.is_some();
        let mut is_active = false;
        if runs {
            if !core::mem::take(&mut module.has_records) {
                module.put(&self.joints, true);
            }
            is_active = module.service.call(homing_call::RUN, 0);
            let set = module.request.as_ref().map_or(0, |r| r.set);
            for (n, joint) in self.joints.iter_mut().enumerate().filter(|(_, j)| j.active) {
                // A partner of a joint of the set is homed with it.
                let may = has(set, n)
                    || joint.homing.is_module_at_work()
                    || is_asked && module.service.state(n).is_homing();
                if let Err(why) = module.take(n, joint, may) {
                    return Ended::Wrong(n, why);
                }
            }
        }
        let mut at_limit = None;
        for (n, joint) in self.joints.iter_mut().enumerate().filter(|(_, j)| j.active) {
            let state = module.service.state(n);
            let is_homing = is_asked && state.is_homing();
            if let Some(request) = module.request.as_mut().filter(|_| is_homing) {
                request.waiting &= !(1 << n);
                module.distrusted &= !(1 << n);
            }
            let waits = module.request.as_ref().is_some_and(|r| has(r.waiting, n));
            if is_homing {
                joint.homing.work_by_module(false);
                is_active = true;
            } else {
                if waits {
                    joint.homing.await_module();
                } else {
                    joint.homing.leave_module();
                }
                if joint.free.by == By::Homing {
                    joint.free.brake();
                }
            }
            joint.homing.open_lock(is_homing && state.wants_open_lock());
            let is_known = !is_homing && !has(module.distrusted, n);
            joint.homing.homed = is_known && state.is_homed();
            if is_homing && joint.free.tp.active && is_at_limit(joint) {
                at_limit.get_or_insert(n);
            }
        }
        if let Some(n) = at_limit {
            return Ended::Failed(n, HomingError::Limit);
        }
        let Some(request) = module.request.as_mut().filter(|_| runs) else { return Ended::No };
        if !core::mem::replace(&mut request.has_run, true) || is_active {
            request.quiet = 0.0;
            return Ended::No;
        }
        request.quiet += dt;
        let (set, waiting) = (request.set, request.waiting);
        let is_missing = |n: &usize| has(set, *n) && !module.service.state(*n).is_homed();
        let missing = (0..self.joints.len()).find(is_missing);
        // Joints that are still homed from before, and that the module has yet to begin.
        let is_to_come = |n: usize| has(waiting, n) && !module.service.state(n).is_idle();
        let is_to_come = request.quiet <= TIMEOUT && (0..self.joints.len()).any(is_to_come);
        match missing {
            None if is_to_come => Ended::No,
            Some(n) if waiting == 0 || request.quiet > TIMEOUT => Ended::Unfinished(n),
            Some(_) => Ended::No,
            None => {
                module.distrusted &= !set;
                for (_, joint) in self.joints.iter_mut().enumerate().filter(|(n, _)| has(set, *n)) {
                    joint.homing.leave_module();
                    joint.homing.homed = true;
                }
                Ended::Done
            }
        }
    }

    /// Aborts all homing of the module. Joints that were being homed are not homed, whatever it says of them.
    pub(crate) fn cancel_module(&mut self, why: &'static str) {
        let Some(module) = &mut self.module else { return };
        module.put(&self.joints, self.machine.is_on());
        for (n, joint) in self.joints.iter().enumerate().filter(|(_, j)| j.active) {
            if joint.homing.is_module_at_work() {
                module.distrusted |= 1 << n;
            }
            if !module.service.state(n).is_idle() {
                module.service.call(homing_call::CANCEL, number(n));
            }
        }
        if let Some(request) = module.request.take() {
            request.ticket.fail(why);
        }
    }

    /// Unhomes joints of the module.
    pub(crate) fn unhome_by_module(&mut self, set: Joints) -> Result<(), Refusal> {
        let Some(module) = &mut self.module else { return Ok(()) };
        module.put(&self.joints, self.machine.is_on());
        let what =
            if self.machine.is_on() { homing_call::UNHOME_FREE } else { homing_call::UNHOME_OFF };
        each(set, |n| {
            module.service.call(what, n);
        });
        let is_kept = |n: &usize| {
            has(set, *n) && !has(module.distrusted, *n) && module.service.state(*n).is_homed()
        };
        match (0..self.joints.len()).find(is_kept) {
            Some(n) => Err(Refusal::joint(
                "the homing module keeps a joint homed",
                "the homing module keeps joint {} homed",
                n,
            )),
            None => Ok(()),
        }
    }

    /// Unhomes joints, whatever a module says of them. The machine is off.
    pub(crate) fn forget_home(&mut self, set: Joints) {
        if set == 0 {
            return;
        }
        each(set, |n| {
            let joint = usize::try_from(n).ok().and_then(|n| self.joints.get_mut(n));
            if let Some(joint) = joint {
                joint.homing.homed = false;
            }
        });
        let Some(module) = &mut self.module else { return };
        module.put(&self.joints, false);
        each(set, |n| {
            module.service.call(homing_call::UNHOME_OFF, n);
        });
        let kept = (0..self.joints.len()).filter(|n| module.service.state(*n).is_homed());
        module.distrusted |= set & kept.fold(0, |kept, n| kept | 1 << n);
    }
}

/// Calls a function for each joint of a set.
fn each(set: Joints, mut call: impl FnMut(i32)) {
    (0..Joints::BITS as usize).filter(|n| has(set, *n)).for_each(|n| call(number(n)));
}

fn number(n: usize) -> i32 {
    i32::try_from(n).unwrap_or(i32::MAX)
}

const UNFINISHED: &str = "the homing module ended without homing a joint";

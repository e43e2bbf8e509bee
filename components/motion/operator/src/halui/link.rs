//! Links of `halui` with motion, the e-stop, and the task.

use hal_component::{
    IoControlRef, IoRequest, IoState, Messages, MotionCommand, MotionRef, MotionRefusal,
    MotionToken, Operator, OperatorRequest, OperatorView, StopEpoch, Touch, Uses, motion_kind,
};
use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Number of requests that wait for the task.
const QUEUE_LEN: usize = 64;
/// Looks at the pins without a sign of the task, after which there is none.
const SILENCE: u32 = 100;

/// Requests for the task, and its state.
#[derive(Debug, Default)]
struct LinkState {
    requests: VecDeque<(OperatorRequest, StopEpoch)>,
    view: Option<OperatorView>,
    /// Looks at the pins since the task has shown its state.
    silent: u32,
}

/// The state between `halui` and the worker of the task.
#[derive(Clone, Debug, Default)]
pub(crate) struct Task(Arc<Mutex<LinkState>>);

impl Task {
    fn state(&self) -> MutexGuard<'_, LinkState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the state of the task, if there is one.
    pub(crate) fn view(&self) -> Option<OperatorView> {
        let mut state = self.state();
        state.silent = state.silent.saturating_add(1);
        if state.silent > SILENCE {
            state.view = None;
            state.requests.clear();
        }
        state.view
    }

    /// Sends a request; returns false if there is no task, or no room.
    fn send(&self, request: OperatorRequest, epoch: StopEpoch) -> bool {
        let mut state = self.state();
        let goes = state.view.is_some() && state.requests.len() < QUEUE_LEN;
        if goes {
            state.requests.push_back((request, epoch));
        }
        goes
    }
}

impl Operator for Task {
    fn take(&self) -> Option<(OperatorRequest, StopEpoch)> {
        self.state().requests.pop_front()
    }

    fn show(&self, view: &OperatorView) {
        let mut state = self.state();
        state.view = Some(*view);
        state.silent = 0;
    }
}

impl Touch for Task {
    fn touch(&self, _: &mut Uses) {}
}

/// Everything that `halui` commands.
#[derive(Debug)]
pub(crate) struct Machine {
    pub(crate) motion: MotionRef,
    pub(crate) io: Option<Mutex<IoControlRef>>,
    pub(crate) task: Task,
    pub(crate) say: Messages,
}

impl Touch for Machine {
    fn touch(&self, uses: &mut Uses) {
        self.motion.touch(uses);
    }
}

impl Machine {
    /// Sends a command to motion, as a local source. Returns false if there was no room for it.
    pub(crate) fn motion(&self, command: &MotionCommand) -> bool {
        match self.motion.push(MotionToken::LOCAL, command) {
            Ok(_) => {}
            Err(MotionRefusal::Full) => {
                self.say.error("motion takes no commands: its queue is full", &[]);
                return false;
            }
            Err(MotionRefusal::NotOwner | MotionRefusal::Refused(_)) => self.say.error(
                "motion refused a command: a speed, increment, scale or joint is not possible",
                &[],
            ),
        }
        true
    }

    /// Sends a command without arguments to motion.
    pub(crate) fn simple(&self, kind: u32) {
        self.motion(&MotionCommand::new(kind));
    }

    /// Sends a request to the e-stop, coolant and lubrication.
    pub(crate) fn io(&self, request: IoRequest) {
        let Some(io) = &self.io else {
            return self.say.error("e-stop and coolant need iocontrol, loaded before", &[]);
        };
        let mut io = io.lock().unwrap_or_else(PoisonError::into_inner);
        if self.task.view().is_none() {
            // Without a task nobody else takes the results.
            while io.result().is_some() {}
        }
        if io.request(request).is_none() {
            self.say.error("iocontrol takes no requests: too many wait", &[]);
        }
    }

    /// Returns the state of e-stop, coolant and tool, if `iocontrol` is loaded.
    pub(crate) fn io_state(&self) -> Option<IoState> {
        self.io.as_ref().map(|io| io.lock().unwrap_or_else(PoisonError::into_inner).state())
    }

    /// Sends a request to the task.
    pub(crate) fn task(&self, request: OperatorRequest) {
        if !self.task.send(request, self.motion.epoch()) {
            self.say.error("modes, programs and MDI need a task, which is not loaded", &[]);
        }
    }

    /// Puts the machine into e-stop. Without an interlock, motion does not read it.
    pub(crate) fn estop(&self) {
        if self.io.is_some() {
            self.io(IoRequest::Estop);
        } else {
            self.say.warn("there is no iocontrol: the e-stop switches motion off", &[]);
        }
        self.simple(motion_kind::DISABLE);
    }

    /// Ends everything that is in progress. A task sees it, and ends coolant and tool change itself.
    pub(crate) fn abort(&self) {
        self.simple(motion_kind::ABORT);
        if self.task.view().is_none() && self.io.is_some() {
            self.io(IoRequest::Abort);
        }
    }
}

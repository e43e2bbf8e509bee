//! Background work of components: on the control side, never in a realtime thread.

use crate::{
    ends::{Control, Doing},
    graph::Ix,
    load::code::Code,
    messages::text::of_panic,
    name::Name,
    realtime::shared::{Shared, next_multiple},
    sync::Arc,
};
use hal_abi::Run;

/// Work that runs periodically.
#[derive(Debug)]
pub(crate) struct Task {
    name: Name,
    pub(crate) owner: Ix,
    period_ns: i64,
    due: i64,
    code: Code<Run>,
    /// Description of the running task, for reports of the end of the process.
    doing: Arc<Doing>,
    failed: bool,
}

impl Task {
    pub(crate) fn new(
        name: Name,
        (owner, doing): (Ix, Arc<Doing>),
        period_ns: i64,
        now: i64,
        code: Code<Run>,
    ) -> Self {
        // At multiples of the period, beginning with the next.
        let due = next_multiple(now, period_ns);
        Self { name, owner, period_ns, due, code, doing, failed: false }
    }

    /// Returns the time at which the task is due, in machine time; `None` if it has failed.
    pub(crate) fn due(&self) -> Option<i64> {
        (!self.failed).then_some(self.due)
    }

    /// Runs the task. Returns the message of its failure.
    pub(crate) fn run(&mut self, now: i64, control: &Control, shared: &Shared) -> Option<String> {
        self.due = next_multiple(now, self.period_ns);
        let done = {
            let _within = control.run(self.doing.clone());
            self.code.run(self.period_ns)
        };
        self.failed = !done.is_ok();
        self.failed.then(|| {
            let (name, cause) = (&self.name, of_panic(&shared.cause));
            format!("task '{name}' has failed and is not run again: {cause}")
        })
    }
}

//! Background work of components: on the control side, never in a realtime thread.

use crate::{
    Engine, ends::Doing, graph::Ix, load::code::Code, name::Name, realtime::fault::said, sync::Arc,
};
use hal_abi::Run;

/// Work that runs periodically.
#[derive(Debug)]
pub(crate) struct Task {
    pub(crate) name: Name,
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
        let due = (now.div_euclid(period_ns) + 1) * period_ns;
        Self { name, owner, period_ns, due, code, doing, failed: false }
    }
}

impl Engine {
    /// Returns the time at which the next task is due, in machine time.
    pub(crate) fn next_task(&self) -> i64 {
        self.tasks.iter().filter(|t| !t.failed).map(|t| t.due).min().unwrap_or(i64::MAX)
    }

    /// Runs every task that is due, in order of creation.
    pub(crate) fn run_tasks(&mut self, now: i64) {
        let mut failed = Vec::new();
        for t in &mut self.tasks {
            if t.failed || t.due > now {
                continue;
            }
            t.due = (now.div_euclid(t.period_ns) + 1) * t.period_ns;
            let done = {
                let _within = self.instance.control.run(t.doing.clone());
                t.code.run(t.period_ns)
            };
            if !done.is_ok() {
                t.failed = true;
                failed.push((t.name.clone(), said(&self.shared.cause)));
            }
        }
        for (name, cause) in failed {
            self.notice(format!("task '{name}' has failed and is not run again: {cause}"));
        }
    }
}

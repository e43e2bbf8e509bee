//! Pins of the task, for other parts of the machine.

use hal_component::{Builder, Error, In, Out, Touch};

/// The pins.
#[derive(Debug, Touch)]
pub(crate) struct Pins {
    job: Out<bool>,
    abort: In<bool>,
    /// Value of `abort` in the step before.
    #[state]
    was: bool,
}

impl Pins {
    pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
        let job = "TRUE while a job is in progress, also while it is paused, and while lines of MDI wait.";
        let abort = "A rising edge aborts, as the command does. The task samples it: hold it until task.job is FALSE.";
        Ok(Self {
            job: b.item("task.job", job, false)?,
            abort: b.item("task.abort", abort, false)?,
            was: false,
        })
    }

    /// Returns whether `abort` has risen since the last call.
    pub(crate) fn aborts(&mut self) -> bool {
        let was = core::mem::replace(&mut self.was, self.abort.get());
        self.was && !was
    }

    /// Shows whether a job is in progress.
    pub(crate) fn show(&self, job: bool) {
        self.job.set(job);
    }
}

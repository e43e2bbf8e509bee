//! Progress of the task: whether it works, the state of the interpreter, and the line in execution.

use super::{Core, Interpreting, Reading};

impl Core {
    /// Returns whether a job is in execution or ending, or a program is checked before its start.
    pub(crate) fn is_busy(&self) -> bool {
        self.job.is_some() || self.ending.is_some() || self.checking.is_before_start()
    }

    /// Returns whether something is in execution or waits; between two lines of MDI that wait, nothing is in execution.
    pub(crate) fn has_work(&self) -> bool {
        self.is_busy() || !self.mdi.is_empty()
    }

    /// Returns the state of the interpreter.
    pub(crate) fn interpreting(&self) -> Interpreting {
        match &self.job {
            None if self.ending.is_some() => Interpreting::Waiting,
            None if self.checking.is_before_start() => Interpreting::Reading,
            None => Interpreting::Idle,
            Some(job) if job.paused => Interpreting::Paused,
            Some(job) if job.reading == Reading::Lines && self.waiting.is_none() => {
                Interpreting::Reading
            }
            Some(_) => Interpreting::Waiting,
        }
    }

    /// Returns the line in execution; 0 without one.
    pub(crate) fn line(&self) -> u32 {
        if self.awaited_tool().is_some() && self.waiting.is_none() {
            return self.queue.front().map_or(0, |entry| entry.origin.line);
        }
        let flight = self.flight.front().map(|f| f.origin.line);
        match (&self.waiting, &self.current) {
            (Some(_), Some(origin)) => origin.line,
            (_, Some(origin)) => flight.unwrap_or(origin.line),
            (_, None) => flight.unwrap_or(0),
        }
    }

    /// Returns the number of steps that wait in the task.
    pub(crate) fn queue_len(&self) -> usize {
        self.queue.len()
    }
}

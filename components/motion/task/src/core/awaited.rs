//! The record of what a job waits for, as values.

use hal_component::Wait;

/// Wait of the job, or of motion if there is no job.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WaitRecord {
    pub(crate) kind: Wait,
    /// Spindle, tool, input or user code.
    pub(crate) number: i32,
    /// Machine time of its begin.
    pub(crate) since: f64,
    /// Machine time at which it ends by itself, if that is known.
    pub(crate) until: Option<f64>,
    /// True if the wait ends by itself.
    pub(crate) ends: bool,
    /// Text that says who is waited for, and how to go on.
    pub(crate) text: Box<str>,
}

impl WaitRecord {
    /// Returns the line of `task.status`, if there is a wait.
    pub(crate) fn line(&self) -> Option<String> {
        let until = match self.until {
            Some(until) => format!("{until:.3}"),
            None if self.ends => "itself".to_owned(),
            None => "never".to_owned(),
        };
        (self.kind != Wait::Nothing).then(|| {
            let (kind, number, since) = (self.kind.name(), self.number, self.since);
            format!("wait for={kind} number={number} since={since:.3} until={until} {}", self.text)
        })
    }
}

/// The record, and what it is made from.
#[derive(Debug, Default)]
pub(super) struct Waits {
    pub(super) record: WaitRecord,
    /// Detail on which the text depends, besides kind and number.
    pub(super) detail: u32,
    pub(super) page: PageHold,
}

/// Inhibition of the feed by a page that is lost, as the pin last said.
#[derive(Debug, Default)]
pub(super) struct PageHold {
    pub(super) holds: bool,
    pub(super) question: Option<u64>,
    pub(super) asked: f64,
}

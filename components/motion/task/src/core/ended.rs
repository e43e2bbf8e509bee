//! Ways in which a job ends, and the reasons that are stops.

/// Reasons for the end of a job by a stop.
pub(super) const STOPPED: &str = "aborted";
pub(super) const ESTOP: &str = "the machine is in e-stop";
pub(super) const OFF: &str = "the machine was switched off";

/// Returns whether this reason for an end is a stop: it is no error.
pub(crate) fn is_stop(why: &str) -> bool {
    [STOPPED, ESTOP, OFF].contains(&why)
}

/// Cause of the end of the last job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum EndedBy {
    /// No job has ended.
    #[default]
    Nothing,
    /// The job is complete.
    End,
    /// An error.
    Error,
    /// An abort.
    Abort,
    /// An e-stop.
    Estop,
    /// The machine was switched off.
    Off,
}

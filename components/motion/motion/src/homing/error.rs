//! Realtime. Reasons why homing of a joint failed, and their texts.

/// Reason why homing of a joint failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HomingError {
    /// A limit switch closed.
    Limit,
    /// The search reached the end of its travel.
    End,
    /// The home switch opened unexpectedly.
    Open,
    /// The home switch closed unexpectedly.
    Closed,
    /// Another joint is on the home switch that both share.
    Shared,
    /// The lock did not open in time.
    NotOpen,
    /// The lock did not close in time.
    NotClosed,
}

impl HomingError {
    /// Returns the text for the command's ticket.
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::Limit => "hit limit while homing",
            Self::End => "end of move while homing: no home switch or index was found",
            Self::Open => "home switch inactive before start of backoff move",
            Self::Closed => "home switch active before start of search move",
            Self::Shared => SHARED.0,
            Self::NotOpen => "the lock did not open in 30 s",
            Self::NotClosed => "the lock did not close in 30 s",
        }
    }

    /// Returns the message for the operator; the numbers are those of the joint and of `home-state`.
    pub(crate) const fn say(self) -> &'static str {
        match self {
            Self::Limit => "j{} hit limit in home state {}",
            Self::End => "j{} end of move in home state {}",
            Self::Open => "j{} home switch inactive before start of backoff move in home state {}",
            Self::Closed => "j{} home switch active before start of search move in home state {}",
            Self::Shared => SHARED.1,
            Self::NotOpen => "j{} lock did not open in 30 s, in home state {}",
            Self::NotClosed => "j{} lock did not close in 30 s, in home state {}",
        }
    }
}

/// Reasons, for the ticket and for the operator, why a joint with a shared switch does not begin.
pub(crate) const SHARED: (&str, &str) = (
    "Cannot home while shared home switch is closed",
    "Cannot home while shared home switch is closed j={}",
);

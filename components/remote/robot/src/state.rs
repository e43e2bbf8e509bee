//! States of a driver, and its news.

use crate::{Refusal, Zero};
use std::fmt;

/// State of the driver.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum State {
    /// There is no connection.
    Closed,
    /// The robot has not yet said where it stands.
    Connected,
    /// The robot waits; the part zero is known.
    Ready,
    /// Lines are executed.
    Running,
    /// The line under way ends, and no other follows.
    Paused,
    /// All lines are executed.
    Ended,
    /// The run has stopped.
    Stopped(Stopped),
}

/// Reason why a run has stopped, with the index of the line that has no answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stopped {
    /// The user has stopped it.
    User(usize),
    /// The connection has ended.
    Lost(usize),
    /// The robot does not answer any more.
    Silent(usize),
    /// The robot has refused the line.
    Refused(usize, Refusal),
    /// Another client is connected.
    Busy,
}

/// News for the user.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Event {
    /// The part zero.
    Zero(Zero),
    /// A line was sent: its index.
    Sent(usize),
    /// A line was executed: its index, and whether its own answer came.
    Executed(usize, bool),
    /// Text that is no answer was received, or an overlong one.
    Noise,
}

impl Stopped {
    /// Returns the index of the line with which a run can resume.
    #[must_use]
    pub const fn line(&self) -> Option<usize> {
        match self {
            Self::User(n) | Self::Lost(n) | Self::Silent(n) | Self::Refused(n, _) => Some(*n),
            Self::Busy => None,
        }
    }
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::User(n) => write!(f, "stopped at line {n}"),
            Self::Lost(n) => write!(f, "the connection was lost at line {n}"),
            Self::Silent(n) => write!(f, "the robot does not answer line {n}"),
            Self::Refused(n, why) => write!(f, "the robot refused line {n}: {why}"),
            Self::Busy => f.write_str("another client is connected to the robot"),
        }
    }
}

//! The side of the machine, as a session sees it.

use crate::Snapshots;
use hal_protocol::Stop;
use std::time::Duration;

/// Joint or axis of a jog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JogTarget {
    /// Number of a joint.
    Joint(u32),
    /// Letter of an axis.
    Axis(char),
}

impl JogTarget {
    /// Returns the argument of a command that names it.
    #[must_use]
    pub fn arg(self) -> String {
        match self {
            Self::Joint(n) => format!("joint={n}"),
            Self::Axis(letter) => format!("axis={}", letter.to_ascii_lowercase()),
        }
    }
}

/// A jog.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jog {
    /// Joint or axis.
    pub target: JogTarget,
    /// Velocity with its sign, in machine units per second.
    pub velocity: f64,
    /// Distance in machine units; without one the jog lasts until it is stopped.
    pub distance: Option<f64>,
}

/// A machine that a session commands.
pub trait Machine {
    /// Reads its state.
    fn poll(&mut self);

    /// Returns the state that was read last.
    fn state(&self) -> &Snapshots;

    /// Gives a command; on a machine without a task, one of the task becomes what does the same. Returns the number of its ticket, if it takes time.
    ///
    /// # Errors
    /// The machine refuses it, with the reason.
    fn command(&mut self, name: &str, args: Vec<String>) -> Result<Option<u64>, String>;

    /// Stops the machine. Returns the number of the ticket of its end, if it takes time.
    ///
    /// # Errors
    /// The machine refuses a part of it, with the reason; every part has been commanded.
    fn stop(&mut self, stop: Stop) -> Result<Option<u64>, String>;

    /// Jogs under the control lease of this session.
    ///
    /// # Errors
    /// The machine refuses it, with the reason.
    fn jog(&mut self, jog: Jog) -> Result<(), String>;

    /// Waits for the end of a command; without a time, as long as it takes.
    ///
    /// # Errors
    /// It failed, it takes longer, or a stop has arrived meanwhile; with the reason.
    fn wait(&mut self, ticket: u64, most: Option<Duration>) -> Result<(), String>;

    /// Takes control for this session, also from another session.
    ///
    /// # Errors
    /// Somebody else has the control lease; with the reason.
    fn take(&mut self) -> Result<(), String>;

    /// Gives control back, if this session has it.
    fn give(&mut self);

    /// Returns whether this session has control.
    fn has_control(&self) -> bool;

    /// Ends the machine.
    ///
    /// # Errors
    /// It does not end, with the reason.
    fn shut_down(&mut self) -> Result<(), String>;

    /// Returns the seconds since 1970.
    fn time(&self) -> f64;
}

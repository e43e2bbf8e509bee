//! Reasons why a machine is not commanded from afar.

use hal_protocol::{Failure, Unlisted};
use std::fmt;

/// Reason why the orders of a machine are not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoOrders {
    /// The engine refuses to list its commands, or does not answer.
    Engine(Failure),
    /// The commands are not those of a machine that can be commanded.
    Unlisted(Unlisted),
}

impl fmt::Display for NoOrders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engine(why) => why.fmt(f),
            Self::Unlisted(why) => why.fmt(f),
        }
    }
}

/// Reason why the plugin `remote` is not in a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoRemote {
    /// The engine does not answer.
    Engine(Failure),
    /// The orders of the machine are not known.
    Orders(NoOrders),
    /// The answer to the request for a list is another one.
    Unlisted(&'static str),
    /// No thread runs a function whose motion could be stopped.
    NoMotion {
        /// Functions that were looked for.
        functs: [&'static str; 2],
    },
    /// The function of the plugin does not run before the controller's.
    Late {
        /// Function of the controller.
        controller: &'static str,
        /// Program that asks.
        program: String,
    },
    /// A pin of the machine is linked otherwise.
    Unreached {
        /// Pin that should reach it.
        from: String,
        /// Pin of the machine.
        to: String,
    },
    /// The engine refuses the changes.
    Refused(Failure),
}

impl fmt::Display for NoRemote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Engine(why) => why.fmt(f),
            Self::Orders(why) => why.fmt(f),
            Self::Unlisted(what) => write!(f, "the engine lists no {what}"),
            Self::NoMotion { functs: [a, b] } => write!(
                f,
                "no thread runs {a} or {b}: this machine has no motion that could be stopped"
            ),
            Self::Late { controller, program } => write!(
                f,
                "function remote is not in the thread of {controller} before it: motion would see a stop a cycle late, or \
                 never; addf it there, before {program} is started"
            ),
            Self::Unreached { from, to } => write!(
                f,
                "{to} is linked, and {from} does not reach it: join both in the machine's HAL file, as \
                 with loadrt or2"
            ),
            Self::Refused(why) => write!(f, "the plugin remote cannot be used: {why}"),
        }
    }
}

impl core::error::Error for NoRemote {}

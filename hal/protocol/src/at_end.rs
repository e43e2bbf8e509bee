//! Commands that are executed when a client's connection ends.

use serde::{Deserialize, Serialize};

/// A command of a component, as in [`crate::Request::Command`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CommandLine {
    /// Full name, `COMPONENT.VERB`.
    pub name: String,
    /// Arguments, each `NAME=VALUE`.
    pub args: Vec<String>,
}

/// Maximum number of commands of [`crate::Request::AtEnd`].
pub const MAX_AT_END: usize = 64;

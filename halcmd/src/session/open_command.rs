//! A command in progress whose end a script does not wait for.

use hal_protocol::At;

/// A command in progress that nobody waits for.
#[derive(Debug)]
pub(crate) struct OpenCommand {
    pub(super) ticket: u64,
    pub(super) name: String,
    pub(super) at: At,
}

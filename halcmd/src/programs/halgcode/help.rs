//! The help of a command.

/// Returns the help of a command: its arguments, its purpose and its options.
pub(super) fn usage_of(name: &str, arguments: &str, purpose: &str, options: &str) -> String {
    format!("Usage: halgcode {name} {arguments}\n{purpose}\n\noptions:\n{options}")
}

//! Messages as they are shown.

use crate::realtime::shared::Cause;

use super::{
    join,
    mailbox::{Message, Spoken},
};

/// Formats a message as it is shown, after its component's name.
pub(crate) fn format(m: &Message, source: &str) -> String {
    // SAFETY: static in a library that is open: messages are read before it is closed.
    let text = unsafe { m.text.get() }.unwrap_or("?");
    let said = join::filled(text, m.numbers.get(..m.n).unwrap_or_default());
    format!("{source}: {said}")
}

/// Formats a text as it is shown, after its component's name.
pub(crate) fn spoken(m: &Spoken, source: &str) -> String {
    format!("{source}: {}", String::from_utf8_lossy(m.bytes()).trim_end())
}

/// Returns the text of a panic.
pub(crate) fn of_panic(cause: &Cause) -> String {
    let (bytes, n) = cause.bytes();
    let text = String::from_utf8_lossy(bytes.get(..n).unwrap_or_default());
    // A longer text was cut, perhaps inside a character.
    let whole = n < bytes.len();
    if whole { text.into_owned() } else { format!("{}…", text.trim_end_matches('\u{fffd}')) }
}

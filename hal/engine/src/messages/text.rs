//! Messages as they are shown.

use super::{
    join,
    mailbox::{Message, Spoken},
};

/// Formats a message as it is shown, after its component's name.
pub(crate) fn worded(m: &Message, speaker: &str) -> String {
    // SAFETY: static in a library that is open: messages are read before it is closed.
    let text = unsafe { m.text.get() }.unwrap_or("?");
    let said = join::filled(text, m.numbers.get(..m.n).unwrap_or_default());
    format!("{speaker}: {said}")
}

/// Formats a text as it is shown, after its component's name.
pub(crate) fn spoken(m: &Spoken, speaker: &str) -> String {
    format!("{speaker}: {}", String::from_utf8_lossy(m.bytes()).trim_end())
}

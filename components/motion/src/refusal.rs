//! Realtime. Why a command was not carried out.

use hal_component::{Messages, TicketHandle};

/// A reason: for whoever waits, and for the operator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refusal {
    text: &'static str,
    say: &'static str,
    number: f64,
}

impl Refusal {
    pub(crate) const fn new(text: &'static str) -> Self {
        Self { text, say: text, number: 0.0 }
    }

    /// The operator is told which joint: it replaces `{}` in `say`.
    pub(crate) const fn joint(text: &'static str, say: &'static str, n: usize) -> Self {
        Self { text, say, number: n as f64 }
    }

    pub(crate) fn report(self, messages: &Messages, ticket: TicketHandle) {
        messages.error(self.say, &[self.number]);
        ticket.fail(self.text);
    }

    pub(crate) fn say(self, messages: &Messages) {
        messages.error(self.say, &[self.number]);
    }

    pub(crate) const fn text(self) -> &'static str {
        self.text
    }
}

//! Realtime. Reasons for refusing a command.

use hal_component::{Messages, TicketHandle};

/// A reason: for the ticket, and for the operator.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refusal {
    text: &'static str,
    say: &'static str,
    numbers: [f64; 4],
}

impl Refusal {
    pub(crate) const fn new(text: &'static str) -> Self {
        Self { text, say: text, numbers: [0.0; 4] }
    }

    /// Creates a refusal whose message to the operator names the joint: it replaces `{}` in `say`.
    pub(crate) const fn joint(text: &'static str, say: &'static str, n: usize) -> Self {
        Self { text, say, numbers: [n as f64, 0.0, 0.0, 0.0] }
    }

    /// Creates a refusal, for the ticket and for the operator, whose text has `{}` for a joint, its position, and its
    /// position according to the kinematics.
    pub(crate) fn at(text: &'static str, n: usize, place: f64, answer: f64) -> Self {
        Self {
            text,
            say: text,
            numbers: [n as f64, rounded(place, 1e6), rounded(answer, 1e6), 0.0],
        }
    }

    /// Creates a refusal, for the ticket and for the operator, whose text has `{}` for numbers.
    pub(crate) fn with(text: &'static str, numbers: [f64; 4]) -> Self {
        Self { text, say: text, numbers: numbers.map(|n| rounded(n, 1e6)) }
    }

    /// Replaces the first number, the line of the program.
    pub(crate) fn on_line(mut self, line: u32) -> Self {
        self.numbers[0] = f64::from(line);
        self
    }

    /// Returns whether a stop has come since the command was given.
    pub(crate) fn is_stale(&self) -> bool {
        self.text == hal_safety::Refused::Stale.text()
    }

    pub(crate) fn fail(self, ticket: TicketHandle) {
        ticket.fail_with(self.text, &self.numbers);
    }

    pub(crate) fn report(self, messages: &Messages, ticket: TicketHandle) {
        self.say(messages);
        self.fail(ticket);
    }

    pub(crate) fn say(self, messages: &Messages) {
        messages.error(self.say, &self.numbers);
    }

    pub(crate) const fn text(self) -> &'static str {
        self.text
    }
}

/// Rounds a number for a message to a fraction of a unit, without digits that are only rounding errors.
pub(crate) fn rounded(number: f64, parts: f64) -> f64 {
    let rounded = libm::rint(number * parts) / parts;
    if rounded.is_finite() { rounded } else { number }
}

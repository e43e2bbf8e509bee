//! Realtime. Report of a failing device.

use crate::Lost;
use hal_component::{Messages, Touch, Uses};

/// Reports a failing device once, until it answers again.
#[derive(Clone, Debug)]
pub struct Report {
    messages: Messages,
    port: u32,
    said: bool,
}

impl Report {
    /// Makes a report for the device numbered `port`.
    #[must_use]
    pub const fn new(messages: Messages, port: u32) -> Self {
        Self { messages, port, said: false }
    }

    /// Records the result of an access. On the first failure, logs `text`, with the error number and the device number
    /// in place of each `{}`.
    pub fn note(&mut self, done: Result<(), Lost>, text: &'static str) {
        match done {
            Ok(()) => self.said = false,
            Err(_) if self.said => {}
            Err(lost) => {
                self.said = true;
                self.messages.error(text, &[f64::from(lost.0), f64::from(self.port)]);
            }
        }
    }
}

impl Touch for Report {
    fn touch(&self, _: &mut Uses) {}
}

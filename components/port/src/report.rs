//! Realtime. What a function says of a device that fails.

use crate::Lost;
use hal_component::{Messages, Touch, Uses};

/// Says once that a device fails, until it answers again.
#[derive(Clone, Debug)]
pub struct Report {
    messages: Messages,
    port: u32,
    said: bool,
}

impl Report {
    /// Nothing said yet, of the device numbered `port`.
    #[must_use]
    pub const fn new(messages: Messages, port: u32) -> Self {
        Self { messages, port, said: false }
    }

    /// Notes how an access went. When it is the first to fail, says `text`, with the number of the
    /// error and that of the device in the places of `{}`.
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

//! Realtime. Report of a failing device.

use crate::Lost;
use hal_component::{Builder, Hardware, Messages, Touch, Uses};

/// Reports a failing device once, until it answers again, and lets the motion controller be off meanwhile.
#[derive(Clone, Debug)]
pub struct Report {
    messages: Messages,
    port: u32,
    hardware: Hardware,
}

impl Report {
    /// Makes a report for the device numbered `port`.
    #[must_use]
    pub fn new(b: &Builder<'_>, port: u32) -> Self {
        Self { messages: b.messages(), port, hardware: b.hardware() }
    }

    /// Records the result of an access. On the first failure, logs `text`, with the error number and the device number
    /// in place of each `{}`.
    pub fn note(&mut self, done: Result<(), Lost>, text: &'static str) {
        let has_failed_now = self.hardware.note(done.is_err());
        if let Err(lost) = done
            && has_failed_now
        {
            self.messages.error(text, &[f64::from(lost.0), f64::from(self.port)]);
        }
    }
}

impl Touch for Report {
    fn touch(&self, _: &mut Uses) {}
}

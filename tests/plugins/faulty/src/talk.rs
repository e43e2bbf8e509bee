//! `talker` and `listener`: byte queues.
use hal_component::{Component, In, Out, Period, Port, Update};

/// Sends one byte a cycle, counting.
#[derive(Component)]
pub(crate) struct Talker {
    /// Destination.
    line: Out<Port>,
    /// Number of bytes sent.
    sent: Out<u32>,
    /// Number of bytes that did not fit into the queue.
    refused: Out<u32>,
}

impl Update for Talker {
    fn update(&mut self, _: Period) {
        let n = self.sent.get();
        #[expect(clippy::cast_possible_truncation, reason = "the low byte is what is sent")]
        let pin = if self.line.get().write(&[n as u8]) { &self.sent } else { &self.refused };
        pin.set(pin.get().wrapping_add(1));
    }
}

/// Takes bytes two at a time.
#[derive(Component)]
pub(crate) struct Listener {
    /// Source.
    line: In<Port>,
    /// Enables listening.
    on: In<bool>,
    /// Number of pairs received.
    pairs: Out<u32>,
    /// The last pair, the first byte in the low half.
    last: Out<u32>,
    /// Number of waiting bytes.
    waiting: Out<u32>,
}

impl Update for Listener {
    fn update(&mut self, _: Period) {
        let line = self.line.get();
        let mut pair = [0; 2];
        if self.on.get() && line.read(&mut pair) {
            self.pairs.set(self.pairs.get().wrapping_add(1));
            self.last.set(u32::from(u16::from_le_bytes(pair)));
        }
        self.waiting.set(u32::try_from(line.readable()).unwrap_or(u32::MAX));
    }
}

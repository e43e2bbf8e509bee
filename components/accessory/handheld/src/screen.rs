//! Realtime. Whole screens: a text counts when the bus has been quiet for a while after its last byte.

pub use crate::st7920::TEXT_LEN;
use crate::st7920::{COLUMNS, Decode};

/// Length of a record: the text, five digits, CR and LF.
pub const RECORD_LEN: usize = TEXT_LEN + 7;
/// Usual quiet time in nanoseconds.
pub const QUIET_NS: i64 = 5_000_000;
/// Number after which counters begin again.
const COUNTER_END: u32 = 100_000;

/// Screens that a decoder finds in the bytes of a bus.
#[derive(Clone, Debug)]
pub struct Screens<D> {
    decoder: D,
    quiet_ns: i64,
    last_byte: i64,
    is_quiet: bool,
    shown: [u8; TEXT_LEN],
    number: u64,
}

impl<D: Decode> Screens<D> {
    /// Returns the screens of a decoder. A text counts after `quiet_ns` nanoseconds without a byte.
    #[must_use]
    pub fn new(decoder: D, quiet_ns: i64) -> Self {
        let shown = *decoder.text();
        Self { decoder, quiet_ns, last_byte: 0, is_quiet: true, shown, number: 1 }
    }

    /// Takes bytes that arrived at a time, with no byte before them for as long as none was taken. Returns whether a new
    /// screen was complete before them.
    pub fn feed(&mut self, bytes: &[u8], now: i64) -> bool {
        let is_new = self.poll(now);
        bytes.iter().for_each(|byte| self.take(*byte, now));
        is_new
    }

    /// Takes a byte that arrived at this time or before.
    pub fn take(&mut self, byte: u8, at: i64) {
        (self.last_byte, self.is_quiet) = (at, false);
        self.decoder.feed(byte);
    }

    /// Advances to a time until which there is no further byte. Returns whether a new screen is complete: the bus is quiet, and the text differs.
    pub fn poll(&mut self, now: i64) -> bool {
        if self.is_quiet || now.saturating_sub(self.last_byte) < self.quiet_ns {
            return false;
        }
        self.is_quiet = true;
        let is_new = self.shown != *self.decoder.text();
        if is_new {
            self.shown = *self.decoder.text();
            self.number = self.number.wrapping_add(1);
        }
        is_new
    }

    /// Returns the latest whole screen.
    #[must_use]
    pub const fn text(&self) -> &[u8; TEXT_LEN] {
        &self.shown
    }

    /// Returns the number of the latest whole screen, from 1.
    #[must_use]
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// Returns whether the bus is quiet.
    #[must_use]
    pub const fn is_quiet(&self) -> bool {
        self.is_quiet
    }

    /// Returns the decoder.
    #[must_use]
    pub const fn decoder(&self) -> &D {
        &self.decoder
    }
}

/// Reader of screens, with a counter of its own.
#[derive(Clone, Debug)]
pub struct ScreenReader {
    seen: u64,
    counter: u32,
    record: [u8; RECORD_LEN],
    /// Number of bytes of the record that have been read.
    read: usize,
}

impl Default for ScreenReader {
    fn default() -> Self {
        Self { seen: 0, counter: 0, record: [0; RECORD_LEN], read: RECORD_LEN }
    }
}

impl ScreenReader {
    /// Returns the next bytes for the reader: the rest of a record, or else a record of the screen, if the reader has not seen
    /// it yet. The reader calls [`took`](Self::took) with the number of bytes that it has used.
    pub fn next(&mut self, text: &[u8; TEXT_LEN], number: u64) -> &[u8] {
        if self.read >= RECORD_LEN && number != self.seen {
            self.seen = number;
            let mut digits = [b'0'; 5];
            let mut rest = self.counter;
            for digit in digits.iter_mut().rev() {
                *digit = b'0' + u8::try_from(rest % 10).unwrap_or(0);
                rest /= 10;
            }
            self.counter = (self.counter + 1) % COUNTER_END;
            let all = text.iter().chain(&digits).chain(b"\r\n");
            for (free, byte) in self.record.iter_mut().zip(all) {
                *free = *byte;
            }
            self.read = 0;
        }
        self.record.get(self.read..).unwrap_or_default()
    }

    /// Notes that the reader has used a number of bytes.
    pub fn took(&mut self, bytes: usize) {
        self.read = self.read.saturating_add(bytes).min(RECORD_LEN);
    }

    /// Returns the counter of the next record.
    #[must_use]
    pub const fn counter(&self) -> u32 {
        self.counter
    }
}

/// Returns a row of a text, 0 to 3.
#[must_use]
pub fn row(text: &[u8; TEXT_LEN], row: usize) -> &[u8] {
    text.get(row * COLUMNS..(row + 1) * COLUMNS).unwrap_or_default()
}

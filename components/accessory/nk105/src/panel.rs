//! Realtime. The text of the display, and the bytes that draw it.

use core::fmt::{self, Write};
use hal_handheld::st7920::{COLUMNS, ROW_BYTES, ROWS, command_bytes, row_bytes};

/// Time between two looks at the text, in seconds.
const REFRESH: f64 = 0.05;
/// Commands after power-on: basic set, display on, clear, increasing addresses.
const BEGIN: [u8; 4] = [0x30, 0x0C, 0x01, 0x06];

/// Text of a row.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ScreenRow {
    bytes: [u8; COLUMNS],
    len: usize,
}

impl Default for ScreenRow {
    fn default() -> Self {
        Self { bytes: [b' '; COLUMNS], len: 0 }
    }
}

impl ScreenRow {
    /// Returns a row with this text, as far as it fits.
    #[must_use]
    pub fn of(text: fmt::Arguments<'_>) -> Self {
        let mut row = Self::default();
        // What does not fit is left out.
        let _: fmt::Result = row.write_fmt(text);
        row
    }

    /// Appends a character if there is room.
    pub fn push(&mut self, byte: u8) {
        if let Some(free) = self.bytes.get_mut(self.len) {
            *free = byte;
            self.len += 1;
        }
    }

    /// Returns the text.
    #[must_use]
    pub fn text(&self) -> &str {
        core::str::from_utf8(self.bytes.get(..self.len).unwrap_or_default()).unwrap_or_default()
    }

    /// Returns whether the row has no text.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }
}

impl Write for ScreenRow {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.push(byte));
        Ok(())
    }
}

/// Burst of bytes to the display.
#[derive(Clone, Copy, Debug)]
pub struct Burst {
    bytes: [u8; ROW_BYTES],
    len: usize,
}

impl Burst {
    /// Returns the bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

/// Display, of which the rows that differ are drawn, one in each cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Panel {
    /// Number of commands after power-on that have been sent.
    begun: usize,
    shown: [ScreenRow; ROWS],
    wanted: [ScreenRow; ROWS],
    /// Seconds since the last look at the text.
    age: f64,
}

impl Panel {
    /// Advances by some seconds. Returns whether the text is to be looked at.
    pub fn is_due(&mut self, seconds: f64) -> bool {
        self.age += seconds;
        self.age >= REFRESH && self.shown == self.wanted
    }

    /// Takes the text, all rows of one moment.
    pub const fn show(&mut self, text: [ScreenRow; ROWS]) {
        (self.wanted, self.age) = (text, 0.0);
    }

    /// Returns the bytes that are to be sent next.
    #[must_use]
    pub fn next(&self) -> Option<Burst> {
        let mut burst = Burst { bytes: [0; ROW_BYTES], len: 0 };
        let mut put = |from: &[u8]| {
            for (free, byte) in burst.bytes.iter_mut().zip(from) {
                *free = *byte;
            }
            burst.len = from.len();
        };
        match BEGIN.get(self.begun) {
            Some(command) => put(&command_bytes(*command)),
            None => {
                let (at, row) = self.difference()?;
                put(&row_bytes(at, &row.bytes));
            }
        }
        Some(burst)
    }

    /// Notes that the bytes of [`next`](Self::next) were sent.
    pub fn sent(&mut self) {
        if self.begun < BEGIN.len() {
            self.begun += 1;
        } else if let Some((at, row)) = self.difference()
            && let Some(shown) = self.shown.get_mut(at)
        {
            *shown = row;
        }
    }

    fn difference(&self) -> Option<(usize, ScreenRow)> {
        let both = self.shown.iter().zip(self.wanted).enumerate();
        both.filter(|(_, (shown, wanted))| *shown != wanted).map(|(at, (_, w))| (at, w)).next()
    }
}

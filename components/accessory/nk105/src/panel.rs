//! Realtime. The text of the display, and the bytes that draw it.

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
    pub fn of(text: &str) -> Self {
        Self::default().and(text)
    }

    /// Returns the row with a further text, as far as it fits.
    #[must_use]
    pub fn and(mut self, text: &str) -> Self {
        text.bytes().for_each(|byte| self.push(byte));
        self
    }

    /// Returns the row with a further number, at the end of a column of this width.
    #[must_use]
    pub fn and_number(self, number: i64, width: usize) -> Self {
        self.and_digits(number, 0, width)
    }

    /// Returns the row with a further number with so many decimals, at the end of a column of this width.
    #[must_use]
    pub fn and_decimals(self, number: f64, decimals: u8, width: usize) -> Self {
        let scale = (0..decimals).fold(1.0, |scale, _| scale * 10.0);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "what is no number is 0, and others are at the ends"
        )]
        let digits = libm::round(number * scale) as i64;
        self.and_digits(digits, decimals.into(), width)
    }

    /// Appends a number, whose last `decimals` digits stand behind a point.
    fn and_digits(mut self, number: i64, decimals: usize, width: usize) -> Self {
        // The digits from the last one on.
        let mut bytes = [b' '; 24];
        let mut len = 0;
        let mut put = |byte: u8| {
            if let Some(free) = bytes.get_mut(len) {
                *free = byte;
                len += 1;
            }
        };
        let mut rest = number.unsigned_abs();
        let mut digits = 0;
        while rest > 0 || digits <= decimals {
            if decimals > 0 && digits == decimals {
                put(b'.');
            }
            put(b'0' + u8::try_from(rest % 10).unwrap_or(0));
            rest /= 10;
            digits += 1;
        }
        if number < 0 {
            put(b'-');
        }
        (len..width).for_each(|_| self.push(b' '));
        bytes.iter().take(len).rev().for_each(|byte| self.push(*byte));
        self
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

#[cfg(test)]
mod tests {
    use super::ScreenRow;

    #[test]
    fn numbers_read_as_they_are_formatted() {
        for n in [0.0, 0.001, -0.001, 1.0, -12.5, 99.999, -123_456.789, 0.0004, f64::NAN, 1e300] {
            let row = ScreenRow::of("X").and_decimals(n, 3, 10).and(" IDLE");
            let kept = if n.is_nan() { 0.0 } else { n };
            let text: String = format!("X{kept:10.3} IDLE").chars().take(16).collect();
            if n < 1e9 {
                assert_eq!(row.text(), text);
            }
        }
        for n in [0, 7, -7, 12, 345, i64::from(i32::MAX), i64::MIN] {
            let text: String = format!("T{n:3}").chars().take(16).collect();
            assert_eq!(ScreenRow::of("T").and_number(n, 3).text(), text);
        }
    }
}

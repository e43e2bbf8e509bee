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
    use super::{Panel, REFRESH, ROWS, ScreenRow, row_bytes};
    use hal_handheld::{Decode as _, St7920, screen::row};

    /// Panel with the display at the other end of its bus.
    #[derive(Default)]
    struct Wired {
        panel: Panel,
        display: St7920,
    }

    impl Wired {
        /// Sends a burst. Returns false if there is none.
        fn send(&mut self) -> bool {
            let burst = self.panel.next();
            if let Some(burst) = burst {
                burst.bytes().iter().for_each(|byte| self.display.feed(*byte));
                self.panel.sent();
            }
            burst.is_some()
        }

        /// Sends all bursts; returns their number.
        fn send_all(&mut self) -> usize {
            core::iter::from_fn(|| self.send().then_some(())).count()
        }

        fn screen(&self) -> String {
            let row = |n| String::from_utf8_lossy(row(self.display.text(), n));
            (0..ROWS).map(|n| row(n).trim_end().to_owned()).collect::<Vec<_>>().join("/")
        }
    }

    #[test]
    fn the_screen_shows_the_text() {
        let mut wired = Wired::default();
        // Characters of a display that was on already.
        row_bytes(2, b"################").iter().for_each(|byte| wired.display.feed(*byte));
        assert_eq!(wired.screen(), "//################/");
        assert_eq!((wired.send_all(), wired.screen().as_str()), (4, "///"));
        wired.panel.show(["X     1.000 IDLE", "", "Z", "17 CHARACTERS ARE"].map(ScreenRow::of));
        // The blank row is not drawn again.
        assert_eq!(wired.send_all(), 3);
        assert_eq!(wired.screen(), "X     1.000 IDLE//Z/17 CHARACTERS AR");
        wired.panel.show(["X     1.000 IDLE", "Y", "Z", ""].map(ScreenRow::of));
        assert_eq!((wired.send_all(), wired.screen().as_str()), (2, "X     1.000 IDLE/Y/Z/"));
        assert_eq!(wired.display.errors(), 0);
    }

    #[test]
    fn rows_of_one_screen_stay_together() {
        let mut wired = Wired::default();
        wired.send_all();
        assert!(!wired.panel.is_due(REFRESH * 0.9) && wired.panel.is_due(REFRESH * 0.2));
        wired.panel.show(["A", "B", "", ""].map(ScreenRow::of));
        assert!(!wired.panel.is_due(REFRESH * 2.0), "no row of this text is drawn yet");
        assert!(wired.send());
        assert!(!wired.panel.is_due(0.0), "one of two rows is drawn");
        assert_eq!(wired.screen(), "A///");
        // A row that found no room on the bus is the next one again.
        let lost = wired.panel.next().unwrap();
        assert_eq!(lost.bytes(), row_bytes(1, b"B               "));
        assert_eq!((wired.send_all(), wired.screen().as_str()), (1, "A/B//"));
        assert!(wired.panel.is_due(0.0));
    }

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

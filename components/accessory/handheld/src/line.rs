//! Lines of text that press keys: `N`, or `N MS` to hold it.

use crate::keypad::Press;
use core::fmt;

/// Longest line in bytes, without its end.
pub const MOST_BYTES: usize = 32;
/// Longest hold of a key in milliseconds.
pub const LONGEST_MS: u32 = 10_000;

/// Reason why a line presses nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BadLine {
    /// Empty.
    Empty,
    /// Longer than [`MOST_BYTES`].
    Long,
    /// A byte of it is no ASCII character.
    Encoding,
    /// A word of it is no whole number.
    Number,
    /// There is no such key; the last key.
    Key(u8),
    /// The time is outside 1 to [`LONGEST_MS`].
    Time,
    /// There are more than two words.
    Words,
}

impl BadLine {
    /// Returns the reason as a text that lives as long as the process.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Empty => "it is empty",
            Self::Long => "it is longer than 32 bytes",
            Self::Encoding => "it is not ASCII text",
            Self::Number => "a word is no whole number",
            Self::Key(_) => "there is no such key",
            Self::Time => "the time is not 1 to 10000 ms",
            Self::Words => "it has more than two words",
        }
    }
}

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())?;
        match self {
            Self::Key(last) => write!(f, ": keys are 1 to {last}"),
            _ => f.write_str(": a line is N, or N MS, such as '13' or '15 500'"),
        }
    }
}

/// Reads a line. `keys` is the number of keys, `period_ms` the time between two frames.
///
/// # Errors
/// The line is no number of a key, or its time is outside its range.
pub fn parse(line: &[u8], keys: u8, period_ms: f64) -> Result<Press, BadLine> {
    if line.len() > MOST_BYTES {
        return Err(BadLine::Long);
    }
    let text = core::str::from_utf8(line).ok().filter(|t| t.is_ascii()).ok_or(BadLine::Encoding)?;
    let mut words = text.split_ascii_whitespace();
    let key = number(words.next().ok_or(BadLine::Empty)?)?;
    let time = words.next().map(number).transpose()?;
    if words.next().is_some() {
        return Err(BadLine::Words);
    }
    let key =
        u8::try_from(key).ok().filter(|n| (1..=keys).contains(n)).ok_or(BadLine::Key(keys))?;
    time.map_or(Ok(Press::short(key)), |ms| press_for(key, ms, period_ms))
}

/// Returns a press of at least this time.
///
/// # Errors
/// The time is outside its range.
pub fn press_for(key: u8, ms: u32, period_ms: f64) -> Result<Press, BadLine> {
    if !(1..=LONGEST_MS).contains(&ms)
        || period_ms.partial_cmp(&0.0) != Some(core::cmp::Ordering::Greater)
    {
        return Err(BadLine::Time);
    }
    let (mut periods, mut so_far) = (1_u32, period_ms);
    while so_far < f64::from(ms) && periods < LONGEST_MS {
        periods += 1;
        so_far = f64::from(periods) * period_ms;
    }
    Ok(Press { key, periods })
}

fn number(word: &str) -> Result<u32, BadLine> {
    let is_plain = word.bytes().all(|b| b.is_ascii_digit());
    if !is_plain {
        return Err(BadLine::Number);
    }
    // A number that fits no u32 is outside every range.
    Ok(word.parse().unwrap_or(u32::MAX))
}

/// Splits bytes into lines. A line without its end waits for the rest.
#[derive(Clone, Debug)]
pub struct LineReader {
    bytes: [u8; MOST_BYTES],
    len: usize,
    is_long: bool,
}

impl Default for LineReader {
    fn default() -> Self {
        Self { bytes: [0; MOST_BYTES], len: 0, is_long: false }
    }
}

impl LineReader {
    /// Takes a byte, and returns the length of the line that it ends: [`line`](Self::line) has its bytes until the next call.
    ///
    /// # Errors
    /// The line was too long.
    pub fn feed(&mut self, byte: u8) -> Option<Result<usize, BadLine>> {
        if byte == b'\n' {
            let len = core::mem::take(&mut self.len);
            let is_long = core::mem::take(&mut self.is_long);
            return Some(if is_long { Err(BadLine::Long) } else { Ok(len) });
        }
        match self.bytes.get_mut(self.len) {
            Some(free) => {
                *free = byte;
                self.len += 1;
            }
            None => self.is_long = true,
        }
        None
    }

    /// Returns the first bytes of the last line.
    #[must_use]
    pub fn line(&self, len: usize) -> &[u8] {
        self.bytes.get(..len).unwrap_or_default()
    }
}

//! Lines of the protocol in both directions.

use std::fmt;

/// Longest line, as long as the robot's buffer.
pub const MAX_LINE: usize = 255;
/// Highest cutting speed, in millimetres per second.
pub const FASTEST: f64 = 15.0;
/// Speed of rapid moves, in millimetres per second.
pub(crate) const RAPID: f64 = 10.0;
/// Cutting speed before any is set, in millimetres per second.
pub(crate) const CUTTING: f64 = 5.0;
/// Time after which a line without an end counts as whole, in seconds.
pub(crate) const QUIET: f64 = 0.05;

/// Line to the robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Command {
    /// `inicio`.
    Start,
    /// `SPEED,v`: cutting speed in millimetres per second.
    Speed(f64),
    /// `JMOVE,x,y,z`: rapid motion to a point of the part frame.
    Rapid([f64; 3]),
    /// `LMOVE,x,y,z`: cutting motion to a point of the part frame.
    Cut([f64; 3]),
    /// `EXIT`.
    Exit,
}

/// Refusal of a line.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Refusal {
    /// The word is not known.
    Unknown,
    /// The numbers are wrong.
    Format,
    /// A number is outside its range, or the point outside the work volume.
    Range,
    /// Another client is connected.
    Busy,
}

/// Line from the robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Answer {
    /// The line before has been executed.
    Done,
    /// Position of the part zero.
    Zero([f64; 3]),
    /// The robot waits for `inicio`.
    Waiting,
    /// The line before is refused.
    Refused(Refusal),
}

impl Command {
    /// Returns the point that a move goes to.
    #[must_use]
    pub const fn target(&self) -> Option<[f64; 3]> {
        match self {
            Self::Rapid(to) | Self::Cut(to) => Some(*to),
            Self::Start | Self::Speed(_) | Self::Exit => None,
        }
    }

    /// Reads a line.
    ///
    /// # Errors
    /// The word is not known, or its numbers are wrong.
    pub fn parse(line: &[u8]) -> Result<Self, Refusal> {
        let text = core::str::from_utf8(line).map_err(|_| Refusal::Unknown)?;
        let mut words = text.trim().split(',');
        let word = words.next().unwrap_or_default();
        let mut numbers = Vec::new();
        let known = ["inicio", "SPEED", "JMOVE", "LMOVE", "EXIT"].contains(&word);
        if !known {
            return Err(Refusal::Unknown);
        }
        for word in words.take(4) {
            numbers.push(number(word).ok_or(Refusal::Format)?);
        }
        match (word, numbers.as_slice()) {
            ("inicio", []) => Ok(Self::Start),
            ("EXIT", []) => Ok(Self::Exit),
            ("SPEED", [v]) => Ok(Self::Speed(*v)),
            ("JMOVE", [x, y, z]) => Ok(Self::Rapid([*x, *y, *z])),
            ("LMOVE", [x, y, z]) => Ok(Self::Cut([*x, *y, *z])),
            _ => Err(Refusal::Format),
        }
    }
}

/// Reads a number: digits with a sign and a dot.
pub(crate) fn number(word: &str) -> Option<f64> {
    let word = word.trim();
    let is_plain =
        !word.is_empty() && word.chars().all(|c| c.is_ascii_digit() || "+-.".contains(c));
    let value = if is_plain { word.parse::<f64>().ok() } else { None };
    value.filter(|x| x.abs() < 1e6)
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start => f.write_str("inicio"),
            Self::Speed(v) => write!(f, "SPEED,{}", Plain(*v)),
            Self::Rapid([x, y, z]) => write!(f, "JMOVE,{},{},{}", Plain(*x), Plain(*y), Plain(*z)),
            Self::Cut([x, y, z]) => write!(f, "LMOVE,{},{},{}", Plain(*x), Plain(*y), Plain(*z)),
            Self::Exit => f.write_str("EXIT"),
        }
    }
}

/// Number with three decimals; 0 has no sign.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = if self.0.abs() < 0.0005 { 0.0 } else { self.0 };
        write!(f, "{rounded:.3}")
    }
}

impl Answer {
    /// Reads a line; `None` if the robot says no such thing.
    #[must_use]
    pub fn parse(line: &[u8]) -> Option<Self> {
        let text = core::str::from_utf8(line).ok()?.trim();
        match text {
            "done" => return Some(Self::Done),
            "Esperando inicio" => return Some(Self::Waiting),
            "error unknown" => return Some(Self::Refused(Refusal::Unknown)),
            "error format" => return Some(Self::Refused(Refusal::Format)),
            "error range" => return Some(Self::Refused(Refusal::Range)),
            "error busy" => return Some(Self::Refused(Refusal::Busy)),
            _ => {}
        }
        let mut numbers = text.split_whitespace().map(number);
        let (x, y, z) = (numbers.next()??, numbers.next()??, numbers.next()??);
        numbers.next().is_none().then_some(Self::Zero([x, y, z]))
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("done"),
            Self::Zero([x, y, z]) => write!(f, "{} {} {}", Plain(*x), Plain(*y), Plain(*z)),
            Self::Waiting => f.write_str("Esperando inicio"),
            Self::Refused(why) => write!(f, "error {why}"),
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "unknown",
            Self::Format => "format",
            Self::Range => "range",
            Self::Busy => "busy",
        })
    }
}

/// Splits bytes into lines that end with LF, CR or both. Longer lines than the limit come out empty of their text.
#[derive(Clone, Debug)]
pub struct Framer {
    line: Vec<u8>,
    is_long: bool,
    limit: usize,
}

impl Default for Framer {
    fn default() -> Self {
        Self::new()
    }
}

impl Framer {
    /// Returns a framer for lines of at most [`MAX_LINE`] bytes.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_limit(MAX_LINE)
    }

    /// Returns a framer for lines of at most this many bytes.
    #[must_use]
    pub const fn with_limit(limit: usize) -> Self {
        Self { line: Vec::new(), is_long: false, limit }
    }

    /// Gives each line that these bytes complete to `take`; an overlong one as `None`.
    pub fn feed(&mut self, bytes: &[u8], mut take: impl FnMut(Option<&[u8]>)) {
        for byte in bytes {
            if matches!(byte, b'\n' | b'\r') {
                self.end(&mut take);
            } else if self.line.len() < self.limit {
                self.line.push(*byte);
            } else {
                self.is_long = true;
            }
        }
    }

    /// Ends a line that has no end of its own, after the sender has been quiet.
    pub fn quiet(&mut self, mut take: impl FnMut(Option<&[u8]>)) {
        self.end(&mut take);
    }

    /// Returns whether a line has begun.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.is_long || !self.line.is_empty()
    }

    fn end(&mut self, take: &mut impl FnMut(Option<&[u8]>)) {
        let line = core::mem::take(&mut self.line);
        if core::mem::take(&mut self.is_long) {
            take(None);
        } else if !line.trim_ascii().is_empty() {
            take(Some(&line));
        }
    }
}

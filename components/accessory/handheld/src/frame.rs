//! Realtime. Frames of keys: a header, a bitmap of pressed keys, a check byte.

use crate::keys::{KeySet, MOST_KEYS};
use core::fmt;

/// Longest frame in bytes.
pub const MOST_BYTES: usize = 16;
/// Shortest frame in bytes: header, one byte of keys, check byte.
pub const LEAST_BYTES: usize = 3;

/// Check byte of a frame, over all bytes before it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Check {
    /// CRC-8 with the polynomial 0x07, initial value 0.
    Crc8,
    /// Sum modulo 256.
    Sum,
    /// Exclusive or.
    Xor,
}

impl Check {
    /// Returns the check by its name: `crc8`, `sum` or `xor`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "crc8" => Some(Self::Crc8),
            "sum" => Some(Self::Sum),
            "xor" => Some(Self::Xor),
            _ => None,
        }
    }

    /// Returns the check byte of these bytes.
    #[must_use]
    pub fn over(self, bytes: &[u8]) -> u8 {
        bytes.iter().fold(0, |check, byte| match self {
            Self::Crc8 => (0..8).fold(check ^ byte, |crc, _| {
                let shifted = crc << 1;
                if crc & 0x80 == 0 { shifted } else { shifted ^ 0x07 }
            }),
            Self::Sum => check.wrapping_add(*byte),
            Self::Xor => check ^ byte,
        })
    }
}

/// Reason why a format is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum WrongFormat {
    /// The header is this number, no byte.
    Header(i64),
    /// The frame has this number of bytes.
    Size(i64),
    /// There are this number of keys in the list.
    Keys(usize),
    /// A key has a bit outside the bitmap: the key, the bit, the last bit of the bitmap.
    Bit(usize, i64, usize),
    /// Two keys have the same bit: the keys.
    Twice(usize, usize),
}

impl fmt::Display for WrongFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header(n) => write!(f, "the header is {n}, must be 0 to 255"),
            Self::Size(n) => {
                write!(f, "a frame has {n} bytes, must have {LEAST_BYTES} to {MOST_BYTES}")
            }
            Self::Keys(n) => write!(f, "the list has {n} keys, must have 1 to {MOST_KEYS}"),
            Self::Bit(key, bit, last) => write!(f, "key {key} is bit {bit}, must be 0 to {last}"),
            Self::Twice(a, b) => write!(f, "keys {a} and {b} are the same bit"),
        }
    }
}

/// Format of a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FrameFormat {
    header: u8,
    size: usize,
    check: Check,
    /// Bit in the bitmap of each key, from key 1 on: byte `bit / 8` after the header, bit `bit % 8` of it.
    bits: [u8; MOST_KEYS as usize],
    keys: u8,
}

impl Default for FrameFormat {
    /// Returns the format of the NK105: header 0xA5, 48 keys in order, CRC-8.
    fn default() -> Self {
        let mut bits = [0; MOST_KEYS as usize];
        for (bit, number) in bits.iter_mut().zip(0_u8..) {
            *bit = number;
        }
        Self { header: 0xA5, size: 8, check: Check::Crc8, bits, keys: MOST_KEYS }
    }
}

impl FrameFormat {
    /// Returns a format. `map` has the bit of each key; if it is empty, key 1 is bit 0, key 2 is bit 1, and so on.
    ///
    /// # Errors
    /// A number is outside its range, or two keys share a bit.
    pub fn new(header: i64, size: i64, check: Check, map: &[i64]) -> Result<Self, WrongFormat> {
        let head = u8::try_from(header).map_err(|_| WrongFormat::Header(header))?;
        let bytes = usize::try_from(size).ok().filter(|n| (LEAST_BYTES..=MOST_BYTES).contains(n));
        let bytes = bytes.ok_or(WrongFormat::Size(size))?;
        let room = (bytes - 2) * 8;
        let mut made = Self { header: head, size: bytes, check, ..Self::default() };
        made.keys = u8::try_from(room).unwrap_or(u8::MAX).min(MOST_KEYS);
        if map.is_empty() {
            return Ok(made);
        }
        made.keys = u8::try_from(map.len())
            .ok()
            .filter(|n| *n <= MOST_KEYS)
            .ok_or(WrongFormat::Keys(map.len()))?;
        for (at, (bit, wanted)) in made.bits.iter_mut().zip(map).enumerate() {
            *bit = u8::try_from(*wanted)
                .ok()
                .filter(|b| usize::from(*b) < room)
                .ok_or(WrongFormat::Bit(at + 1, *wanted, room - 1))?;
            if let Some(other) = map.iter().take(at).position(|b| b == wanted) {
                return Err(WrongFormat::Twice(other + 1, at + 1));
            }
        }
        Ok(made)
    }

    /// Returns the length of a frame in bytes.
    #[must_use]
    pub const fn size(&self) -> usize {
        self.size
    }

    /// Returns the number of keys.
    #[must_use]
    pub const fn keys(&self) -> u8 {
        self.keys
    }

    /// Returns the bytes of a frame, in the first bytes of the array, and their number.
    #[must_use]
    pub fn encode(&self, pressed: KeySet) -> ([u8; MOST_BYTES], usize) {
        let mut bytes = [0; MOST_BYTES];
        if let Some(first) = bytes.first_mut() {
            *first = self.header;
        }
        for (key, bit) in (1..=self.keys).zip(self.bits) {
            if pressed.has(key)
                && let Some(byte) = bytes.get_mut(1 + usize::from(bit / 8))
            {
                *byte |= 1 << (bit % 8);
            }
        }
        let check = self.check.over(bytes.get(..self.size - 1).unwrap_or_default());
        if let Some(last) = bytes.get_mut(self.size - 1) {
            *last = check;
        }
        (bytes, self.size)
    }

    /// Returns the keys of a whole frame; `None` if its check byte is wrong.
    fn decode(&self, bytes: &[u8]) -> Option<KeySet> {
        let (check, rest) = bytes.split_last()?;
        if self.check.over(rest) != *check {
            return None;
        }
        let is_down = |bit: u8| {
            rest.get(1 + usize::from(bit / 8)).is_some_and(|byte| byte & (1 << (bit % 8)) != 0)
        };
        let pressed = (1..=self.keys).zip(self.bits).filter(|(_, bit)| is_down(*bit));
        Some(pressed.fold(KeySet::NONE, |set, (key, _)| set.with(KeySet::of(key))))
    }
}

/// Result of a byte that completes something.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Received {
    /// A frame whose check byte is right.
    Keys(KeySet),
    /// A frame with a wrong check byte, a frame without its end, or as many bytes without a header.
    Bad,
}

/// Reader of frames, which finds the next frame after lost and wrong bytes.
#[derive(Clone, Copy, Debug)]
pub struct FrameReader {
    format: FrameFormat,
    bytes: [u8; MOST_BYTES],
    len: usize,
    /// Bytes outside frames since the last frame.
    stray: usize,
}

impl FrameReader {
    /// Returns a reader before its first byte.
    #[must_use]
    pub const fn new(format: FrameFormat) -> Self {
        Self { format, bytes: [0; MOST_BYTES], len: 0, stray: 0 }
    }

    /// Takes a byte.
    pub fn feed(&mut self, byte: u8) -> Option<Received> {
        if self.len == 0 && byte != self.format.header {
            self.stray += 1;
            if self.stray < self.format.size {
                return None;
            }
            self.stray = 0;
            return Some(Received::Bad);
        }
        if let Some(free) = self.bytes.get_mut(self.len) {
            *free = byte;
            self.len += 1;
        }
        if self.len < self.format.size {
            return None;
        }
        let whole = self.bytes.get(..self.len).unwrap_or_default();
        if let Some(keys) = self.format.decode(whole) {
            (self.len, self.stray) = (0, 0);
            return Some(Received::Keys(keys));
        }
        // The header may have been a byte of another frame, whose own header is among these bytes.
        let next = whole.iter().skip(1).position(|b| *b == self.format.header);
        let from = next.map_or(self.len, |at| at + 1);
        self.bytes.copy_within(from..self.len, 0);
        (self.len, self.stray) = (self.len - from, 0);
        Some(Received::Bad)
    }

    /// Ends what has begun, after the line has been silent. Returns whether bytes were lost.
    pub fn silence(&mut self) -> bool {
        let lost = self.len + self.stray > 0;
        (self.len, self.stray) = (0, 0);
        lost
    }
}

//! Realtime. Process data of a remote as pins.

use crate::numbers::within;
use hal_component::{In, Io, Out, ParamRw, Touch, Uses};

/// Process data of one direction, the first bit lowest.
pub(crate) type Word = u128;

/// Datum that comes from a remote.
pub(crate) struct Taken {
    pub(super) at: u32,
    pub(super) bits: u32,
    pub(super) pins: TakenPins,
}

pub(super) enum TakenPins {
    Bits(Vec<(Out<bool>, Out<bool>)>),
    Boolean(Out<bool>, Out<bool>),
    Number { value: Out<f64>, scale: ParamRw<f64>, signed: bool },
    Float(Out<f64>),
    Stream(Out<u32>),
    Encoder(Box<Wheel>),
}

/// Encoder of a remote.
pub(super) struct Wheel {
    pub(super) count: Out<i32>,
    pub(super) position: Out<f64>,
    pub(super) raw: Out<i32>,
    pub(super) reset: Io<bool>,
    pub(super) index: Io<bool>,
    pub(super) scale: ParamRw<f64>,
    pub(super) per_turn: ParamRw<u32>,
    pub(super) last: Option<u32>,
    pub(super) counts: i32,
    pub(super) zero: i32,
}

/// Datum that goes to a remote.
pub(crate) struct Given {
    pub(super) at: u32,
    pub(super) bits: u32,
    pub(super) pins: GivenPins,
}

pub(super) enum GivenPins {
    Bits(Vec<(In<bool>, ParamRw<bool>)>),
    /// Bits that the remote can read and write: it gets those of the pins.
    Both(Vec<Io<bool>>),
    Boolean(In<bool>, ParamRw<bool>),
    Number {
        value: In<f64>,
        low: ParamRw<f64>,
        high: ParamRw<f64>,
        scale: ParamRw<f64>,
        signed: bool,
    },
    Float(In<f64>),
    Stream(In<u32>),
}

impl Touch for Taken {
    fn touch(&self, uses: &mut Uses) {
        match &self.pins {
            TakenPins::Bits(bits) => {
                for (level, not) in bits {
                    level.touch(uses);
                    not.touch(uses);
                }
            }
            TakenPins::Boolean(level, not) => {
                level.touch(uses);
                not.touch(uses);
            }
            TakenPins::Number { value, scale, .. } => {
                value.touch(uses);
                scale.touch(uses);
            }
            TakenPins::Float(value) => value.touch(uses),
            TakenPins::Stream(value) => value.touch(uses),
            TakenPins::Encoder(wheel) => {
                wheel.count.touch(uses);
                wheel.position.touch(uses);
                wheel.raw.touch(uses);
                wheel.reset.touch(uses);
                wheel.index.touch(uses);
                wheel.scale.touch(uses);
                wheel.per_turn.touch(uses);
            }
        }
    }
}

impl Touch for Given {
    fn touch(&self, uses: &mut Uses) {
        match &self.pins {
            GivenPins::Bits(bits) => {
                for (level, invert) in bits {
                    level.touch(uses);
                    invert.touch(uses);
                }
            }
            GivenPins::Both(bits) => {
                for level in bits {
                    level.touch(uses);
                }
            }
            GivenPins::Boolean(level, invert) => {
                level.touch(uses);
                invert.touch(uses);
            }
            GivenPins::Number { value, low, high, scale, .. } => {
                value.touch(uses);
                low.touch(uses);
                high.touch(uses);
                scale.touch(uses);
            }
            GivenPins::Float(value) => value.touch(uses),
            GivenPins::Stream(value) => value.touch(uses),
        }
    }
}

impl Taken {
    /// Takes the datum from what came. `begins` is true in the first exchange of a start.
    pub(crate) fn take(&mut self, from: Word, begins: bool) {
        let bits = from >> self.at;
        let raw = low(bits) & mask(self.bits);
        match &mut self.pins {
            TakenPins::Bits(pins) => {
                let mut rest = bits;
                for (level, not) in pins {
                    let bit = rest & 1 == 1;
                    rest >>= 1;
                    level.set(bit);
                    not.set(!bit);
                }
            }
            TakenPins::Boolean(level, not) => {
                level.set(raw != 0);
                not.set(raw == 0);
            }
            TakenPins::Number { value, scale, signed } => {
                let part = if *signed {
                    f64::from(extended(raw, self.bits)) / libm::exp2(f64::from(self.bits - 1))
                } else {
                    f64::from(raw) / f64::from(mask(self.bits))
                };
                value.set(part * scale.get());
            }
            TakenPins::Float(value) => value.set(f64::from(f32::from_bits(raw))),
            TakenPins::Stream(value) => value.set(raw),
            TakenPins::Encoder(wheel) => wheel.take(raw, self.bits, begins),
        }
    }
}

impl Wheel {
    fn take(&mut self, raw: u32, bits: u32, begins: bool) {
        // A remote that was started again may have forgotten its count.
        let last = self.last.filter(|_| !begins).unwrap_or(raw);
        self.last = Some(raw);
        let moved = extended(raw.wrapping_sub(last) & mask(bits), bits);
        self.counts = self.counts.wrapping_add(moved);
        if self.reset.get() {
            self.zero = self.counts;
        }
        let count = self.counts.wrapping_sub(self.zero);
        let scale = self.scale.get();
        let scale = if scale.is_finite() && scale.abs() >= 1e-20 { scale } else { 1.0 };
        self.raw.set(self.counts);
        self.count.set(count);
        self.position.set(f64::from(count) / scale);
    }
}

impl Given {
    /// Puts the datum into what goes.
    pub(crate) fn give(&self, to: &mut Word) {
        let value = match &self.pins {
            GivenPins::Bits(pins) => {
                row(pins.iter().map(|(level, invert)| level.get() != invert.get()))
            }
            GivenPins::Both(pins) => row(pins.iter().map(Io::get)),
            GivenPins::Boolean(level, invert) => {
                if level.get() == invert.get() {
                    0
                } else {
                    Word::from(mask(self.bits))
                }
            }
            GivenPins::Number { value, low, high, scale, signed } => {
                let value = within(value.get(), low.get(), high.get()) / scale.get();
                Word::from(part(value, self.bits, *signed))
            }
            GivenPins::Float(value) => Word::from(single(value.get()).to_bits()),
            GivenPins::Stream(value) => Word::from(value.get() & mask(self.bits)),
        };
        *to |= value << self.at;
    }
}

/// Returns the bits of a row, the first lowest.
fn row(bits: impl Iterator<Item = bool>) -> Word {
    bits.take(128).enumerate().fold(0, |all, (n, bit)| all | Word::from(bit) << n)
}

/// Returns a number of bits that are 1, at most 32.
const fn mask(bits: u32) -> u32 {
    if bits >= 32 { u32::MAX } else { (1 << bits) - 1 }
}

#[expect(clippy::cast_possible_truncation, reason = "the low half")]
pub(super) const fn low(word: Word) -> u32 {
    word as u32
}

/// Returns a number of so many bits with its sign.
const fn extended(raw: u32, bits: u32) -> i32 {
    let unused = 32_u32.saturating_sub(bits);
    if unused >= 32 { 0 } else { (raw << unused).cast_signed() >> unused }
}

/// Returns the number of so many bits for a part of the whole range; 0 for NaN.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn part(x: f64, bits: u32, signed: bool) -> u32 {
    if signed {
        let whole = libm::exp2(f64::from(bits - 1));
        let number = within(libm::floor(x * whole), -whole, whole - 1.0);
        (number as i32).cast_unsigned() & mask(bits)
    } else {
        within(x * f64::from(mask(bits)), 0.0, f64::from(mask(bits))) as u32
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the remote has single precision")]
const fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers as LinuxCNC's driver sends them.
    #[test]
    fn a_part_of_the_range_is_a_number() {
        let unsigned = [
            (0.33, 84),
            (0.999, 254),
            (0.25, 63),
            (1.0, 255),
            (2.0, 255),
            (-0.1, 0),
            (f64::NAN, 0),
            (f64::INFINITY, 255),
        ];
        for (x, number) in unsigned {
            assert_eq!(part(x, 8, false), number, "{x}");
        }
        let signed = [
            (-0.5, 0xC0),
            (1.0, 0x7F),
            (-1.0, 0x80),
            (-0.995, 0x80),
            (0.251, 0x20),
            (-7.0, 0x80),
            (f64::NAN, 0),
        ];
        for (x, number) in signed {
            assert_eq!(part(x, 8, true), number, "{x}");
        }
        assert_eq!(part(1.0, 32, false), u32::MAX);
        assert_eq!(part(-1.0, 32, true), 0x8000_0000);
        assert_eq!(part(0.123_45, 16, false), 0x1F9A);
    }

    #[test]
    fn signs_reach_the_whole_number() {
        let rows = [(0xC8, 8, -56), (0x7F, 8, 127), (1, 2, 1), (3, 2, -1), (5, 0, 0)];
        for (raw, bits, number) in rows {
            assert_eq!(extended(raw, bits), number);
        }
        assert_eq!(extended(u32::MAX, 32), -1);
        assert_eq!((mask(0), mask(8), mask(32), mask(96)), (0, 255, u32::MAX, u32::MAX));
    }
}

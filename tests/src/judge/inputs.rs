//! What the judge gives to inputs: chance, ramps, edges and extremes.

use crate::random::Random;
use hal_protocol::Value;

/// What a round does to its inputs.
#[derive(Clone, Copy, Debug)]
pub enum Style {
    /// Numbers by chance, of a size by chance.
    Chance,
    /// Numbers that grow and shrink steadily and cross each other.
    Ramps,
    /// Numbers that stay, and now and then jump.
    Edges,
    /// Every number that a type has, the odd ones first.
    Extremes,
}

impl Style {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Chance, Self::Ramps, Self::Edges, Self::Extremes];
}

/// One input's way through a round.
#[derive(Debug)]
pub(super) struct Source {
    style: Style,
    value: f64,
    slope: f64,
    size: f64,
    often: u64,
}

impl Source {
    /// Begins a round.
    pub(super) fn new(style: Style, r: &mut Random) -> Self {
        let size = r.pick(&[0.1, 1.0, 1.0, 10.0, 1000.0]);
        let often = 1 + r.below(20);
        Self { style, value: r.unit() * size, slope: r.unit() * size / 50.0, size, often }
    }

    /// It has another value each time that it is asked.
    pub(super) fn each_time(self) -> Self {
        Self { often: 1, ..self }
    }

    /// The next value of the type of `now`, if there is one.
    pub(super) fn next(&mut self, now: Value, r: &mut Random) -> Option<Value> {
        match self.style {
            Style::Chance => self.value = r.unit() * self.size,
            Style::Ramps => {
                self.value += self.slope;
                if self.value.abs() > self.size {
                    self.slope = -self.slope;
                }
            }
            Style::Edges | Style::Extremes => {
                if r.below(self.often) != 0 {
                    return None;
                }
                self.value = (r.unit() * self.size).round();
            }
        }
        let odd = r.index(3) > 0 && matches!(self.style, Style::Extremes);
        #[expect(clippy::cast_possible_truncation, reason = "small")]
        let whole = self.value.round() as i64;
        Some(match now {
            Value::Bit(_) => Value::Bit(if matches!(self.style, Style::Ramps | Style::Edges) {
                self.value > 0.0
            } else {
                r.index(2) == 0
            }),
            Value::Float(_) => Value::Float(if odd { r.pick(&ODD) } else { self.value }),
            Value::S32(_) if odd => {
                Value::S32(r.pick(&[i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX - 1, i32::MAX]))
            }
            Value::S32(_) => Value::S32(i32::try_from(whole).unwrap()),
            Value::U32(_) if odd => {
                Value::U32(r.pick(&[0, 1, i32::MAX as u32, 1 << 31, u32::MAX - 1, u32::MAX]))
            }
            Value::U32(_) => Value::U32(u32::try_from(whole.abs()).unwrap()),
            Value::S64(_) if odd => Value::S64(r.pick(&[i64::MIN, -1, 0, 1, 1 << 53, i64::MAX])),
            Value::S64(_) => Value::S64(whole),
            Value::U64(_) if odd => Value::U64(r.pick(&[0, 1, 1 << 53, 1 << 63, u64::MAX])),
            Value::U64(_) => Value::U64(whole.unsigned_abs()),
            Value::Port(_) => return None,
        })
    }
}

/// Numbers at the edges.
const ODD: [f64; 18] = [
    0.0,
    -0.0,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    1e300,
    2_147_483_648.0,
    -2_147_483_649.0,
    4_294_967_296.0,
    1e19,
    0.5,
    -0.5,
    1.5,
    2.5,
];

/// A value as a number.
pub(super) fn float(value: Value) -> f64 {
    match value {
        Value::Bit(b) => f64::from(u8::from(b)),
        Value::Float(f) => f,
        Value::S32(n) => n.into(),
        Value::U32(n) => n.into(),
        Value::S64(n) => n as f64,
        Value::U64(n) => n as f64,
        Value::Port(_) => 0.0,
    }
}

/// A number as a value of the type of `like`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "what is beyond the type is at its end"
)]
pub(super) fn of(like: Value, number: f64) -> Value {
    match like {
        Value::Bit(_) => Value::Bit(number != 0.0),
        Value::Float(_) => Value::Float(number),
        Value::S32(_) => Value::S32(number as i32),
        Value::U32(_) => Value::U32(number as u32),
        Value::S64(_) => Value::S64(number as i64),
        Value::U64(_) => Value::U64(number as u64),
        Value::Port(_) => like,
    }
}

/// A number as a size: no sign, and not 0.
pub(super) fn positive(value: Value) -> Value {
    match value {
        Value::Float(f) => Value::Float(if f.is_finite() { f.abs().max(1e-3) } else { 1e9 }),
        Value::S32(n) => Value::S32(n.checked_abs().unwrap_or(i32::MAX).max(1)),
        Value::S64(n) => Value::S64(n.checked_abs().unwrap_or(i64::MAX).max(1)),
        Value::U32(n) => Value::U32(n.max(1)),
        Value::U64(n) => Value::U64(n.max(1)),
        other => other,
    }
}

/// A number within a range: what is outside is taken round it.
pub(super) fn within(value: Value, [low, high]: [f64; 2]) -> Value {
    #[expect(clippy::cast_possible_truncation, reason = "bounds of a file")]
    let around = |n: i64| {
        let (low, high) = (low as i64, high as i64);
        low + n.rem_euclid(high - low + 1)
    };
    match value {
        Value::Float(f) if low <= f && f <= high => value,
        Value::Float(f) if f.is_finite() => Value::Float(low + f.abs() % (high - low)),
        Value::Float(_) => Value::Float(low),
        Value::S32(n) => Value::S32(i32::try_from(around(n.into())).unwrap()),
        Value::U32(n) => Value::U32(u32::try_from(around(n.into())).unwrap()),
        Value::S64(n) => Value::S64(around(n)),
        Value::U64(n) => Value::U64(u64::try_from(around(n.cast_signed())).unwrap()),
        Value::Bit(_) | Value::Port(_) => value,
    }
}

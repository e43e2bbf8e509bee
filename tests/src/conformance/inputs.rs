//! Stimuli that the judge applies to inputs: random numbers, ramps, edges and extremes.

use super::case::Case;
use crate::random::Random;
use hal_protocol::Value;

/// Kind of stimulus of a round.
#[derive(Clone, Copy, Debug)]
pub enum Style {
    /// Random numbers of random magnitude.
    Chance,
    /// Numbers that rise and fall steadily and cross each other.
    Ramps,
    /// Numbers that stay constant and jump now and then.
    Edges,
    /// Every special number of a type, the exceptional ones first.
    Extremes,
}

impl Style {
    /// All styles.
    pub const ALL: [Self; 4] = [Self::Chance, Self::Ramps, Self::Edges, Self::Extremes];
}

/// An input with its stimulus for a round, and its constraints.
#[derive(Debug)]
pub(super) struct Driven {
    /// Name of our pin.
    pub(super) name: String,
    /// Name of LinuxCNC's pin.
    pub(super) theirs: String,
    first: Value,
    /// True for parameters and pins that both sides write: they are set only now and then.
    seldom: bool,
    steady: bool,
    positive: bool,
    number: bool,
    finite: bool,
    nonzero: bool,
    larger: f64,
    range: Option<[f64; 2]>,
    evenly: bool,
    values: Vec<f64>,
    often: Option<u64>,
    /// Our output that this input follows, and its factor: a pin or a number.
    follows: Option<(String, Option<String>)>,
    source: Source,
}

impl Driven {
    /// Creates the stimulus of the input of these two names for a round.
    pub(super) fn new(
        case: &Case,
        style: Style,
        (name, theirs): (&str, String),
        first: Value,
        seldom: bool,
        r: &mut Random,
    ) -> Self {
        let tame = matches!(style, Style::Extremes) && case.keeps(name, |i| i.tame);
        let often = case.told(name, |i| i.often);
        let follows = case.told(name, |i| i.follows.clone().map(|pin| (pin, i.times.clone())));
        let source = Source::new(if tame { Style::Chance } else { style }, r);
        Self {
            name: name.to_owned(),
            theirs,
            first,
            seldom,
            steady: case.keeps(name, |i| i.steady),
            positive: case.keeps(name, |i| i.positive),
            number: case.keeps(name, |i| i.number),
            finite: case.keeps(name, |i| i.finite),
            nonzero: case.keeps(name, |i| i.nonzero),
            larger: case.told(name, |i| i.larger).unwrap_or(1.0),
            range: case.told(name, |i| i.range),
            evenly: case.keeps(name, |i| i.evenly),
            values: case
                .told(name, |i| (!i.values.is_empty()).then(|| i.values.clone()))
                .unwrap_or_default(),
            often,
            follows,
            source: if often.is_some() { source.each_time() } else { source },
        }
    }

    /// Returns the value to set before a cycle, if any; `get` reads an output.
    pub(super) fn next(
        &mut self,
        is_first: bool,
        all_at_first: bool,
        r: &mut Random,
        mut get: impl FnMut(&str) -> Value,
    ) -> Option<Value> {
        if let Some((pin, times)) = &self.follows {
            let by = times.as_ref().map_or(1.0, |t| t.parse().unwrap_or_else(|_| float(get(t))));
            return Some(of(self.first, float(get(pin)) * by));
        }
        let now_and_then = (is_first && all_at_first) || r.below(40) == 0;
        let due = match self.often {
            _ if self.steady => is_first,
            Some(n) => is_first || r.below(n) == 0,
            None => !self.seldom || now_and_then,
        };
        let outside = self.range.is_some_and(|range| within(self.first, range) != self.first);
        let next = match (self.range, self.values.as_slice()) {
            (Some(range), []) if self.evenly => Some(of(self.first, whole_in(range, r))),
            (_, []) => self.source.next(self.first, r),
            (_, values) => Some(of(self.first, r.pick(values))),
        };
        let next =
            if is_first && outside { next.or(Some(self.first)) } else { next.filter(|_| due) };
        let value = next.map(|v| if self.larger == 1.0 { v } else { larger(v, self.larger) });
        let value = if self.positive { positive(value?) } else { value? };
        let value = self.range.map_or(value, |range| within(value, range));
        let refused = match value {
            Value::Float(f) => {
                self.number && f.is_nan()
                    || self.finite && !f.is_finite()
                    || self.nonzero && f == 0.0
            }
            Value::U32(n) => self.nonzero && n == 0,
            Value::S32(n) => self.nonzero && n == 0,
            _ => false,
        };
        (!refused).then_some(value)
    }
}

/// Generator of one input's values.
#[derive(Debug)]
pub(crate) struct Source {
    style: Style,
    value: f64,
    slope: f64,
    size: f64,
    often: u64,
}

impl Source {
    /// Starts a generator for a round.
    pub(crate) fn new(style: Style, r: &mut Random) -> Self {
        let size = r.pick(&[0.1, 1.0, 1.0, 10.0, 1000.0]);
        let often = 1 + r.below(20);
        Self { style, value: r.unit() * size, slope: r.unit() * size / 50.0, size, often }
    }

    /// Makes the generator return a new value at each call.
    pub(crate) fn each_time(self) -> Self {
        Self { often: 1, ..self }
    }

    /// Returns whether the values are those at the edges of the range.
    pub(crate) const fn is_odd(&self) -> bool {
        matches!(self.style, Style::Extremes)
    }

    /// Returns the next value, of the type of `now`, if there is one.
    pub(crate) fn next(&mut self, now: Value, r: &mut Random) -> Option<Value> {
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

/// Exceptional numbers.
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

/// Returns a random integer within a range.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounds of a file")]
fn whole_in([low, high]: [f64; 2], r: &mut Random) -> f64 {
    low + r.below((high - low) as u64 + 1) as f64
}

/// Returns a number multiplied by `n`, saturated to its type.
fn larger(value: Value, n: f64) -> Value {
    if matches!(value, Value::Bit(_)) { value } else { of(value, float(value) * n) }
}

/// Returns a value as a float.
pub(crate) fn float(value: Value) -> f64 {
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

/// Converts a number to a value of the type of `like`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "what is beyond the type is at its end"
)]
pub(crate) fn of(like: Value, number: f64) -> Value {
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

/// Makes a number positive: the absolute value, and never 0.
pub(crate) fn positive(value: Value) -> Value {
    match value {
        Value::Float(f) => Value::Float(if f.is_finite() { f.abs().max(1e-3) } else { 1e9 }),
        Value::S32(n) => Value::S32(n.checked_abs().unwrap_or(i32::MAX).max(1)),
        Value::S64(n) => Value::S64(n.checked_abs().unwrap_or(i64::MAX).max(1)),
        Value::U32(n) => Value::U32(n.max(1)),
        Value::U64(n) => Value::U64(n.max(1)),
        other => other,
    }
}

/// Returns whether a value's type can hold a range; bits are not checked.
pub(crate) fn fits(like: Value, range: [f64; 2]) -> bool {
    matches!(like, Value::Bit(_) | Value::Port(_))
        || range.iter().all(|bound| float(of(like, *bound)) == *bound)
}

/// Wraps a number into a range.
pub(crate) fn within(value: Value, [low, high]: [f64; 2]) -> Value {
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

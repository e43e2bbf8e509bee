//! Values: text form, bits in a cell, and form on the wire.

mod wire;

use serde::{Deserialize, Serialize};

/// A HAL type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Type {
    /// A boolean.
    Bit,
    /// A 64-bit floating-point number.
    Float,
    /// A signed 32-bit integer.
    S32,
    /// An unsigned 32-bit integer.
    U32,
    /// A byte queue.
    Port,
    /// A signed 64-bit integer.
    S64,
    /// An unsigned 64-bit integer.
    U64,
}

/// All accepted spellings. The first one of each type is the one that is printed.
const NAMES: &[(&str, Type)] = &[
    ("bit", Type::Bit),
    ("float", Type::Float),
    ("s32", Type::S32),
    ("u32", Type::U32),
    ("s64", Type::S64),
    ("u64", Type::U64),
    ("port", Type::Port),
    ("bool", Type::Bit),
    ("real", Type::Float),
    ("sint", Type::S64),
    ("uint", Type::U64),
    ("signed", Type::S32),
    ("unsigned", Type::U32),
    ("si32", Type::S32),
    ("ui32", Type::U32),
];

impl Type {
    /// Returns the type of this name, old or new spelling. Ignores letter case.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        NAMES.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, t)| *t)
    }

    /// Returns the name of the type.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bit => "bit",
            Self::Float => "float",
            Self::S32 => "s32",
            Self::U32 => "u32",
            Self::Port => "port",
            Self::S64 => "s64",
            Self::U64 => "u64",
        }
    }

    /// Returns the code of the type in the plugin ABI.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Bit => 1,
            Self::Float => 2,
            Self::S32 => 3,
            Self::U32 => 4,
            Self::Port => 5,
            Self::S64 => 6,
            Self::U64 => 7,
        }
    }

    /// Returns the type with this code.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::Bit,
            2 => Self::Float,
            3 => Self::S32,
            4 => Self::U32,
            5 => Self::Port,
            6 => Self::S64,
            7 => Self::U64,
            _ => return None,
        })
    }

    /// Returns a hint that describes the values of this type.
    #[must_use]
    pub const fn expects(self) -> &'static str {
        match self {
            Self::Bit => "expected TRUE or FALSE (or 1, 0, ON, OFF, YES, NO)",
            Self::Float => "expected a number such as 12.5 or 1e-3",
            Self::S32 => "expected an integer from -2147483648 to 2147483647",
            Self::U32 => "expected an integer from 0 to 4294967295",
            Self::S64 => "expected an integer from -9223372036854775808 to 9223372036854775807",
            Self::U64 => "expected an integer from 0 to 18446744073709551615",
            Self::Port => "expected a queue size from 1 to 65536",
        }
    }
}

/// A value with its type.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// A boolean.
    Bit(bool),
    /// A 64-bit floating-point number.
    Float(f64),
    /// A signed 32-bit integer.
    S32(i32),
    /// An unsigned 32-bit integer.
    U32(u32),
    /// A signed 64-bit integer.
    S64(i64),
    /// An unsigned 64-bit integer.
    U64(u64),
    /// Size of a byte queue in bytes. Zero if there is no queue.
    Port(u64),
}

impl PartialEq for Value {
    /// Compares bit for bit, so that a NaN equals itself.
    fn eq(&self, other: &Self) -> bool {
        self.ty() == other.ty() && self.bits() == other.bits()
    }
}

/// Reason why a text is not a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueError {
    /// Invalid syntax.
    Invalid,
    /// Valid syntax, but the value is out of range.
    Range,
}

impl Value {
    /// Returns the value as a number: a bit as 0 or 1, an integer of 64 bits as the nearest number.
    #[must_use]
    pub fn number(&self) -> f64 {
        match *self {
            Self::Bit(on) => f64::from(u8::from(on)),
            Self::Float(x) => x,
            Self::S32(n) => f64::from(n),
            Self::U32(n) => f64::from(n),
            Self::S64(n) => n as f64,
            Self::U64(n) | Self::Port(n) => n as f64,
        }
    }

    /// Returns the value as a number; `None` for a port, which has no value of its own.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        (!matches!(self, Self::Port(_))).then(|| self.number())
    }

    /// Returns the type of the value.
    #[must_use]
    pub const fn ty(&self) -> Type {
        match self {
            Self::Bit(_) => Type::Bit,
            Self::Float(_) => Type::Float,
            Self::S32(_) => Type::S32,
            Self::U32(_) => Type::U32,
            Self::S64(_) => Type::S64,
            Self::U64(_) => Type::U64,
            Self::Port(_) => Type::Port,
        }
    }

    /// Returns the bits that a cell holds for this value. The cell of a port does not hold its
    /// size.
    #[must_use]
    pub const fn bits(&self) -> u64 {
        match *self {
            Self::Bit(b) => b as u64,
            Self::Float(f) => f.to_bits(),
            Self::S32(i) => i.cast_unsigned() as u64,
            Self::U32(u) => u as u64,
            Self::S64(i) => i.cast_unsigned(),
            Self::U64(u) | Self::Port(u) => u,
        }
    }

    /// Returns the value that a cell's bits represent.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "32-bit values live in the low half")]
    pub const fn from_bits(ty: Type, bits: u64) -> Self {
        match ty {
            Type::Bit => Self::Bit(bits & 0xff != 0),
            Type::Float => Self::Float(f64::from_bits(bits)),
            Type::S32 => Self::S32((bits as u32).cast_signed()),
            Type::U32 => Self::U32(bits as u32),
            Type::S64 => Self::S64(bits.cast_signed()),
            Type::U64 => Self::U64(bits),
            Type::Port => Self::Port(bits),
        }
    }

    /// Parses a value as users write it: booleans as words or 0 and 1; integers in C notation (0x…,
    /// 0…) with an optional sign; floats as C's `strtod` reads them (including nan, inf and 0x…).
    ///
    /// # Errors
    /// The syntax is invalid, or the value is outside the range of the type.
    pub fn parse(ty: Type, text: &str) -> Result<Self, ValueError> {
        match ty {
            Type::Bit => {
                let is = |words: &[&str]| words.iter().any(|w| w.eq_ignore_ascii_case(text));
                if is(&["1", "TRUE", "ON", "YES"]) {
                    Ok(Self::Bit(true))
                } else if is(&["0", "FALSE", "OFF", "NO"]) {
                    Ok(Self::Bit(false))
                } else {
                    Err(ValueError::Invalid)
                }
            }
            Type::Float => float(text).map(Self::Float),
            Type::S32 => narrow(integer(text)?).map(Self::S32),
            Type::U32 => narrow(integer(text)?).map(Self::U32),
            Type::S64 => narrow(integer(text)?).map(Self::S64),
            Type::U64 => narrow(integer(text)?).map(Self::U64),
            Type::Port => match narrow::<u64>(integer(text)?)? {
                n @ 1..=65536 => Ok(Self::Port(n)),
                _ => Err(ValueError::Range),
            },
        }
    }
}

fn narrow<T: TryFrom<i128>>(n: i128) -> Result<T, ValueError> {
    T::try_from(n).map_err(|_| ValueError::Range)
}

/// Parses an integer in C notation (base 0), as `strtol` does. Ignores surrounding white space.
fn integer(text: &str) -> Result<i128, ValueError> {
    let text = text.trim();
    let (negative, digits) = match text.as_bytes().first() {
        Some(b'-') => (true, text.get(1..).unwrap_or("")),
        Some(b'+') => (false, text.get(1..).unwrap_or("")),
        _ => (false, text),
    };
    let (radix, digits) =
        match (digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")), digits) {
            (Some(hex), _) => (16, hex),
            (None, d) if d.len() > 1 && d.starts_with('0') => (8, d.get(1..).unwrap_or("")),
            (None, d) => (10, d),
        };
    if digits.is_empty() || !digits.chars().all(|c| c.is_digit(radix)) {
        return Err(ValueError::Invalid);
    }
    let n = i128::from_str_radix(digits, radix).map_err(|_| ValueError::Range)?;
    Ok(if negative { -n } else { n })
}

/// Parses a float as `strtod` does in the C locale.
fn float(text: &str) -> Result<f64, ValueError> {
    let text = text.trim();
    let (sign, body) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    if body.starts_with(['+', '-']) {
        return Err(ValueError::Invalid);
    }
    if let Some(hex) = body.strip_prefix("0x").or_else(|| body.strip_prefix("0X")) {
        return hex_float(hex).map(|f| sign * f);
    }
    let lower = body.to_ascii_lowercase();
    if lower == "nan" {
        return Ok(f64::NAN);
    }
    if lower == "inf" || lower == "infinity" {
        return Ok(sign * f64::INFINITY);
    }
    if !lower.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return Err(ValueError::Invalid);
    }
    let f: f64 = lower.parse().map_err(|_| ValueError::Invalid)?;
    if f.is_finite() { Ok(sign * f) } else { Err(ValueError::Range) }
}

/// Parses the part after 0x: `10`, `1.8`, `1p4`.
fn hex_float(text: &str) -> Result<f64, ValueError> {
    let (mantissa, exponent) = match text.split_once(['p', 'P']) {
        Some((m, e)) => (m, e.parse::<i32>().map_err(|_| ValueError::Invalid)?),
        None => (text, 0),
    };
    let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    if whole.is_empty() && part.is_empty() {
        return Err(ValueError::Invalid);
    }
    let mut value = 0.0;
    for c in whole.chars().chain(part.chars()) {
        value = value * 16.0 + f64::from(c.to_digit(16).ok_or(ValueError::Invalid)?);
    }
    let places = i32::try_from(part.len()).map_err(|_| ValueError::Range)?;
    let f = value * 2_f64.powi(exponent.saturating_sub(places.saturating_mul(4)));
    if f.is_finite() { Ok(f) } else { Err(ValueError::Range) }
}

impl core::fmt::Display for Value {
    /// Formats the value as `getp` prints it: `TRUE`, `%.7g`, decimal.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            Self::Bit(b) => f.write_str(if b { "TRUE" } else { "FALSE" }),
            Self::Float(x) => f.write_str(&general(x)),
            Self::S32(i) => write!(f, "{i}"),
            Self::U32(u) => write!(f, "{u}"),
            Self::S64(i) => write!(f, "{i}"),
            Self::U64(u) | Self::Port(u) => write!(f, "{u}"),
        }
    }
}

/// Formats a float as C's `%.7g`.
fn general(x: f64) -> String {
    const DIGITS: i32 = 7;
    if x.is_nan() {
        return if x.is_sign_negative() { "-nan".into() } else { "nan".into() };
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf".into() } else { "-inf".into() };
    }
    if x == 0.0 {
        return if x.is_sign_negative() { "-0".into() } else { "0".into() };
    }
    let scientific = format!("{x:.6e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |s: &str| -> String {
        if s.contains('.') {
            s.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            s.to_owned()
        }
    };
    if !(-4..DIGITS).contains(&exponent) {
        let sign = if exponent < 0 { '-' } else { '+' };
        return format!("{}e{sign}{:02}", trim(mantissa), exponent.abs());
    }
    let places = usize::try_from(DIGITS - 1 - exponent).unwrap_or(0);
    trim(&format!("{x:.places$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_becomes_a_value_or_says_why_not() {
        for (ty, text, want) in [
            (Type::Bit, "yes", Ok(Value::Bit(true))),
            (Type::Bit, "2", Err(ValueError::Invalid)),
            (Type::S32, "0x10", Ok(Value::S32(16))),
            (Type::S32, "-017", Ok(Value::S32(-15))),
            (Type::S32, "2147483648", Err(ValueError::Range)),
            (Type::S32, "1.5", Err(ValueError::Invalid)),
            (Type::S32, "", Err(ValueError::Invalid)),
            (Type::S32, "0", Ok(Value::S32(0))),
            (Type::U32, "-1", Err(ValueError::Range)),
            (Type::U64, "18446744073709551615", Ok(Value::U64(u64::MAX))),
            (Type::S64, "-9223372036854775808", Ok(Value::S64(i64::MIN))),
            (Type::Float, ".25", Ok(Value::Float(0.25))),
            (Type::Float, "0x10", Ok(Value::Float(16.0))),
            (Type::Float, "-inf", Ok(Value::Float(f64::NEG_INFINITY))),
            (Type::Float, "1e999", Err(ValueError::Range)),
            (Type::Float, "1.2.3", Err(ValueError::Invalid)),
            (Type::Float, "--1", Err(ValueError::Invalid)),
            (Type::Port, "0", Err(ValueError::Range)),
        ] {
            assert_eq!(Value::parse(ty, text), want, "{ty:?} {text}");
        }
    }

    #[test]
    fn floats_print_as_c_prints_them() {
        for (x, want) in [
            (0.1, "0.1"),
            (1e20, "1e+20"),
            (285.714_285_714, "285.7143"),
            (1_234_567.8, "1234568"),
            (12_345_678.0, "1.234568e+07"),
            (0.0001, "0.0001"),
            (0.000_01, "1e-05"),
            (-0.0, "-0"),
            (9_999_999.6, "1e+07"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Value::Float(x).to_string(), want);
        }
    }

    #[test]
    fn the_wire_keeps_every_bit() {
        for v in [
            Value::Float(f64::INFINITY),
            Value::Float(-0.0),
            Value::Float(0.1 + 0.2),
            Value::S64(i64::MIN),
            Value::U64(u64::MAX),
            Value::U32(7),
            Value::Bit(true),
        ] {
            let json = serde_json::to_string(&v).unwrap();
            assert_eq!(serde_json::from_str::<Value>(&json).unwrap(), v, "{json}");
        }
    }
}

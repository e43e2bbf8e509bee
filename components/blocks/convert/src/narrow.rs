//! Realtime. Conversion of values to another type.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "casts are what was asked for"
)]

/// Documentation of a component, and its example with input and output.
macro_rules! words {
    ($name:literal, $doc:literal, $lines:literal) => {
        (
            $name,
            concat!(
                $doc,
                "\n\n# Example\n\n```hal\nloadrt ",
                $name,
                " names=conv\nloadrt threads name1=servo period1=1000000\naddf conv servo\nstart\n",
                $lines,
                "```"
            ),
        )
    };
}

/// Conversion of a value to another type.
pub(crate) trait Narrow<To> {
    /// Name of the component, and its first line of documentation.
    const WORDS: (&'static str, &'static str);
    /// True if some values do not fit.
    const CAN_FAIL: bool;
    /// Converts as the processor does, which wraps a value that does not fit. Returns the result, and whether
    /// converting it back gives another value.
    fn plain(self) -> (To, bool);
    /// Returns the nearest value that fits, and whether it differs.
    fn nearest(self) -> (To, bool);
}

macro_rules! fits {
    ($($from:ty => $to:ty, $name:literal, $doc:literal, $lines:literal, |$v:ident| $value:expr;)*) => {$(
        impl Narrow<$to> for $from {
            const WORDS: (&'static str, &'static str) = words!($name, $doc, $lines);
            const CAN_FAIL: bool = false;
            fn plain(self) -> ($to, bool) {
                let $v = self;
                ($value, false)
            }
            fn nearest(self) -> ($to, bool) {
                self.plain()
            }
        }
    )*};
}
fits! {
    bool => f64, "conv_bit_float", "A bit as a number, 0 or 1.", "setp conv.in 1\nrun 1ms\ngetp conv.out # -> 1\n", |v| f64::from(u8::from(v));
    bool => i32, "conv_bit_s32", "A bit as a 32-bit number, 0 or 1.", "setp conv.in 1\nrun 1ms\ngetp conv.out # -> 1\n", |v| i32::from(v);
    bool => i64, "conv_bit_s64", "A bit as a 64-bit number, 0 or 1.", "setp conv.in 1\nrun 1ms\ngetp conv.out # -> 1\n", |v| i64::from(v);
    bool => u32, "conv_bit_u32", "A bit as an unsigned 32-bit number, 0 or 1.", "setp conv.in 1\nrun 1ms\ngetp conv.out # -> 1\n", |v| u32::from(v);
    bool => u64, "conv_bit_u64", "A bit as an unsigned 64-bit number, 0 or 1.", "setp conv.in 1\nrun 1ms\ngetp conv.out # -> 1\n", |v| u64::from(v);
    i32 => f64, "conv_s32_float", "A 32-bit number as a float.", "setp conv.in -7\nrun 1ms\ngetp conv.out # -> -7\n", |v| f64::from(v);
    i32 => i64, "conv_s32_s64", "A 32-bit number in 64 bits.", "setp conv.in -7\nrun 1ms\ngetp conv.out # -> -7\n", |v| i64::from(v);
    u32 => f64, "conv_u32_float", "An unsigned 32-bit number as a float.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\n", |v| f64::from(v);
    u32 => i64, "conv_u32_s64", "An unsigned 32-bit number in 64 bits.", "setp conv.in 4000000000\nrun 1ms\ngetp conv.out # -> 4000000000\n", |v| i64::from(v);
    u32 => u64, "conv_u32_u64", "An unsigned 32-bit number in 64 bits.", "setp conv.in 4000000000\nrun 1ms\ngetp conv.out # -> 4000000000\n", |v| u64::from(v);
    i64 => f64, "conv_s64_float", "A 64-bit number as a float, which has 53 bits.", "setp conv.in -7\nrun 1ms\ngetp conv.out # -> -7\n", |v| v as f64;
    u64 => f64, "conv_u64_float", "An unsigned 64-bit number as a float, which has 53 bits.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\n",
        |v| v as f64;
}

macro_rules! narrows {
    ($($from:ty => $to:ty, $name:literal, $doc:literal, $lines:literal;)*) => {$(
        impl Narrow<$to> for $from {
            const WORDS: (&'static str, &'static str) = words!($name, $doc, $lines);
            const CAN_FAIL: bool = true;
            fn plain(self) -> ($to, bool) {
                let to = self as $to;
                (to, to as $from != self)
            }
            fn nearest(self) -> ($to, bool) {
                let fits = <$to>::try_from(self);
                let end = if i128::from(self) < 0 { <$to>::MIN } else { <$to>::MAX };
                (fits.unwrap_or(end), fits.is_err())
            }
        }
    )*};
}
narrows! {
    i32 => u32, "conv_s32_u32", "A 32-bit number as an unsigned one.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in -7\nrun 1ms\ngetp conv.out # -> 0\ngetp conv.out-of-range # -> TRUE\n";
    i32 => u64, "conv_s32_u64", "A 32-bit number as an unsigned one of 64 bits.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in -7\nrun 1ms\ngetp conv.out # -> 0\ngetp conv.out-of-range # -> TRUE\n";
    i64 => i32, "conv_s64_s32", "A 64-bit number in 32 bits.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in 5000000000\nrun 1ms\ngetp conv.out # -> 2147483647\ngetp conv.out-of-range # -> TRUE\n";
    i64 => u32, "conv_s64_u32", "A 64-bit number as an unsigned one of 32 bits.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in -7\nrun 1ms\ngetp conv.out # -> 0\ngetp conv.out-of-range # -> TRUE\n";
    i64 => u64, "conv_s64_u64", "A 64-bit number as an unsigned one.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in -7\nrun 1ms\ngetp conv.out # -> 0\ngetp conv.out-of-range # -> TRUE\n";
    u32 => i32, "conv_u32_s32", "An unsigned 32-bit number as one with a sign.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in 4000000000\nrun 1ms\ngetp conv.out # -> 2147483647\ngetp conv.out-of-range # -> TRUE\n";
    u64 => i32, "conv_u64_s32", "An unsigned 64-bit number as one of 32 bits with a sign.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in 5000000000\nrun 1ms\ngetp conv.out # -> 2147483647\ngetp conv.out-of-range # -> TRUE\n";
    u64 => i64, "conv_u64_s64", "An unsigned 64-bit number as one with a sign.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in 18446744073709551615\nrun 1ms\ngetp conv.out # -> 9223372036854775807\ngetp conv.out-of-range # -> TRUE\n";
    u64 => u32, "conv_u64_u32", "An unsigned 64-bit number in 32 bits.", "setp conv.in 7\nrun 1ms\ngetp conv.out # -> 7\nsetp conv.clamp 1\nsetp conv.in 5000000000\nrun 1ms\ngetp conv.out # -> 4294967295\ngetp conv.out-of-range # -> TRUE\n";
}

macro_rules! to_bit {
    ($($from:ty, $name:literal, $doc:literal, $lines:literal;)*) => {$(
        impl Narrow<bool> for $from {
            const WORDS: (&'static str, &'static str) = words!($name, $doc, $lines);
            const CAN_FAIL: bool = true;
            fn plain(self) -> (bool, bool) {
                (self != 0, !(0..=1).contains(&self))
            }
            fn nearest(self) -> (bool, bool) {
                (self > 0, !(0..=1).contains(&self))
            }
        }
    )*};
}
to_bit! {
    i32, "conv_s32_bit", "Tests whether a 32-bit number is not 0.",
        "setp conv.in 7\nrun 1ms\ngetp conv.out # -> TRUE\ngetp conv.out-of-range # -> TRUE\n";
    i64, "conv_s64_bit", "Tests whether a 64-bit number is not 0.",
        "setp conv.in 7\nrun 1ms\ngetp conv.out # -> TRUE\ngetp conv.out-of-range # -> TRUE\n";
    u32, "conv_u32_bit", "Tests whether an unsigned 32-bit number is not 0.",
        "setp conv.in 7\nrun 1ms\ngetp conv.out # -> TRUE\ngetp conv.out-of-range # -> TRUE\n";
    u64, "conv_u64_bit", "Tests whether an unsigned 64-bit number is not 0.",
        "setp conv.in 7\nrun 1ms\ngetp conv.out # -> TRUE\ngetp conv.out-of-range # -> TRUE\n";
}

macro_rules! from_float {
    ($($to:ty, $name:literal, $doc:literal, $lines:literal, $most:expr, |$v:ident| $plain:expr;)*) => {$(
        impl Narrow<$to> for f64 {
            const WORDS: (&'static str, &'static str) = words!($name, $doc, $lines);
            const CAN_FAIL: bool = true;
            fn plain(self) -> ($to, bool) {
                let $v = self;
                let to: $to = $plain;
                (to, to as f64 != self)
            }
            fn nearest(self) -> ($to, bool) {
                if self > $most as f64 {
                    ($most, true)
                } else if self < <$to>::MIN as f64 {
                    (<$to>::MIN, true)
                } else {
                    (self.plain().0, false)
                }
            }
        }
    )*};
}
from_float! {
    i32, "conv_float_s32", "A float as a 32-bit number, without its fraction.", "setp conv.in 2.9\nrun 1ms\ngetp conv.out # -> 2\nsetp conv.clamp 1\nsetp conv.in 1e12\nrun 1ms\ngetp conv.out # -> 2147483647\ngetp conv.out-of-range # -> TRUE\n", i32::MAX,
        |v| hal_component::to_s32(v);
    i64, "conv_float_s64", "A float as a 64-bit number, without its fraction.", "setp conv.in 2.9\nrun 1ms\ngetp conv.out # -> 2\nsetp conv.clamp 1\nsetp conv.in 1e300\nrun 1ms\ngetp conv.out # -> 9223372036854775807\ngetp conv.out-of-range # -> TRUE\n", i64::MAX,
        |v| wide(v);
    u32, "conv_float_u32", "A float as an unsigned 32-bit number, without its fraction.", "setp conv.in 2.9\nrun 1ms\ngetp conv.out # -> 2\nsetp conv.clamp 1\nsetp conv.in -5\nrun 1ms\ngetp conv.out # -> 0\ngetp conv.out-of-range # -> TRUE\n",
        i32::MAX.cast_unsigned(), |v| wide(v) as u32;
    u64, "conv_float_u64", "A float as an unsigned 64-bit number, without its fraction.", "setp conv.in 2.9\nrun 1ms\ngetp conv.out # -> 2\nsetp conv.clamp 1\nsetp conv.in -5\nrun 1ms\ngetp conv.out # -> 0\ngetp conv.out-of-range # -> TRUE\n", u64::MAX,
        |v| v as u64;
}

/// Converts a float to 64 bits as the processor does: a value that does not fit becomes the lowest.
fn wide(v: f64) -> i64 {
    let fits = i64::MIN as f64 <= v && v <= i64::MAX as f64;
    if fits { v as i64 } else { i64::MIN }
}

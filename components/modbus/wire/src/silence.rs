//! Times: those without bytes that separate frames on serial lines, and seconds as nanoseconds.

/// Silence that Huanyang's inverters need before a request, in nanoseconds: one that follows sooner has no answer.
pub const HUANYANG_SILENCE_NS: i64 = 6_000_000;
/// Silence at more than 19200 bits per second, in nanoseconds, as the standard fixes it.
const FAST_NS: i64 = 1_750_000;
const SECOND_NS: i64 = 1_000_000_000;

/// Returns the time of one character of `bits` bits (start, data, parity, stop) on a line, in nanoseconds.
#[must_use]
pub const fn char_ns(baud: u32, bits: u8) -> i64 {
    let baud = if baud == 0 { 1 } else { baud as i64 };
    SECOND_NS * bits as i64 / baud
}

/// Returns up to 100,000 s as nanoseconds; anything else is no time, and 0.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "at most 100,000 s")]
pub const fn nanoseconds(seconds: f64) -> i64 {
    if 0.0 < seconds && seconds <= 100_000.0 { (seconds * 1e9) as i64 } else { 0 }
}

/// Returns the silence between frames on a line, in nanoseconds: 3.5 characters, or 1.75 ms above 19200 bits per second.
#[must_use]
pub const fn silence_ns(baud: u32, bits: u8) -> i64 {
    if baud > 19200 { FAST_NS } else { char_ns(baud, bits) * 7 / 2 }
}

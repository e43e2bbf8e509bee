//! Realtime. Single-precision arithmetic, as LinuxCNC uses it.

use hal_component::Period;

/// Rounds to single precision, which LinuxCNC uses for many of its values.
#[expect(clippy::cast_possible_truncation, reason = "meant so")]
pub(super) fn short(number: f64) -> f32 {
    number as f32
}

/// Adds one period to a time in seconds.
pub(super) fn later(time: f32, period: Period) -> f32 {
    short(f64::from(time) + period.secs())
}

/// Subtracts one period from a time in seconds.
pub(super) fn sooner(time: f32, period: Period) -> f32 {
    short(f64::from(time) - period.secs())
}

/// Limits a number to 1 to `most`.
pub(super) const fn at_most(number: i32, most: i32) -> i32 {
    if number < 1 {
        1
    } else if number > most {
        most
    } else {
        number
    }
}

/// Adds a fractional number of counts to counts in single precision, as LinuxCNC does.
#[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
pub(super) fn sum(counts: i32, by: f64) -> i32 {
    (f64::from(counts as f32) + by) as f32 as i32
}

//! Realtime. Numbers as LinuxCNC keeps them, with 24 bits.

use hal_component::Period;

/// A number with the 24 bits that LinuxCNC keeps of many.
#[expect(clippy::cast_possible_truncation, reason = "meant so")]
pub(super) fn short(number: f64) -> f32 {
    number as f32
}

/// A time and a cycle.
pub(super) fn later(time: f32, period: Period) -> f32 {
    short(f64::from(time) + period.secs())
}

/// A time less a cycle.
pub(super) fn sooner(time: f32, period: Period) -> f32 {
    short(f64::from(time) - period.secs())
}

/// A number of 1 or more, and no more than that.
pub(super) const fn at_most(number: i32, most: i32) -> i32 {
    if number < 1 {
        1
    } else if number > most {
        most
    } else {
        number
    }
}

/// Counts and a part of some, summed with 24 bits as LinuxCNC does.
#[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
pub(super) fn sum(counts: i32, by: f64) -> i32 {
    (f64::from(counts as f32) + by) as f32 as i32
}

//! Realtime. Numbers for registers, with defined results for NaN and what does not fit.

use hal_component::ParamRw;

/// Returns a number without its fraction, limited to 0 and `most`; 0 for NaN.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
pub(crate) fn whole(x: f64, most: u32) -> u32 {
    (x as u32).min(most)
}

/// Returns the low half of a count, which a pin shows: it goes round.
#[expect(clippy::cast_possible_truncation, reason = "the pin goes round")]
pub(crate) const fn low(counts: i64) -> i32 {
    counts as i32
}

/// Returns `x` limited to two bounds; 0 for NaN.
pub(crate) fn within(x: f64, low: f64, high: f64) -> f64 {
    if x < low {
        low
    } else if x > high {
        high
    } else if x.is_nan() {
        0.0
    } else {
        x
    }
}

/// Returns the counts or steps per unit; sets a scale closer to 0 than 1e-20, an infinite one or NaN to 1.
pub(crate) fn per_unit(scale: ParamRw<f64>) -> f64 {
    let value = scale.get();
    if value.is_finite() && value.abs() >= 1e-20 {
        return value;
    }
    scale.set(1.0);
    1.0
}

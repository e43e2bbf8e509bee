//! Realtime. Comparisons that say what they do with crossed bounds and with what is not a number.

use hal_component::ParamRw;

/// The least dead band of a divisor.
const LEAST: f64 = 1e-12;

/// `x`, or `min` when `x` is below it.
pub(crate) fn larger(x: f64, min: f64) -> f64 {
    if x < min { min } else { x }
}

/// `x`, or `max` when `x` is above it.
pub(crate) fn smaller(x: f64, max: f64) -> f64 {
    if x > max { max } else { x }
}

/// `x` within bounds; when they cross, `min` goes to those below it and `max` to all others.
pub(crate) fn within(x: f64, min: f64, max: f64) -> f64 {
    if x < min { min } else { smaller(x, max) }
}

/// A divisor kept `deadband` away from zero, which is itself kept positive.
pub(crate) fn away(x: f64, deadband: &ParamRw<f64>) -> f64 {
    if deadband.get() < LEAST {
        deadband.set(LEAST);
    }
    let least = deadband.get();
    // Where the dead band is not a number, -0 is 0 all the same.
    let x = x + 0.0;
    if x.abs() < least { if x < 0.0 { -least } else { least } } else { x }
}

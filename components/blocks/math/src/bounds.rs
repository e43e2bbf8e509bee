//! Realtime. Comparisons with defined results for crossed bounds and NaN.

use hal_component::ParamRw;

/// Minimum of a divisor's deadband.
const LEAST: f64 = 1e-12;

/// Returns `x`, or `min` if `x` is below it.
pub(crate) fn larger(x: f64, min: f64) -> f64 {
    if x < min { min } else { x }
}

/// Returns `x`, or `max` if `x` is above it.
pub(crate) fn smaller(x: f64, max: f64) -> f64 {
    if x > max { max } else { x }
}

/// Limits `x`; if the bounds are crossed, an `x` below `min` gives `min`, and any other gives `max`.
pub(crate) fn within(x: f64, min: f64, max: f64) -> f64 {
    if x < min { min } else { smaller(x, max) }
}

/// Keeps a divisor at least `deadband` away from zero, and `deadband` itself at its minimum or above.
pub(crate) fn away(x: f64, deadband: &ParamRw<f64>) -> f64 {
    if deadband.get() < LEAST {
        deadband.set(LEAST);
    }
    let least = deadband.get();
    // Turns -0 into 0, which matters if the deadband is NaN.
    let x = x + 0.0;
    if x.abs() < least { if x < 0.0 { -least } else { least } } else { x }
}

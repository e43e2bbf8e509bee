//! Realtime. Conversion of floats to integers, and scales by which floats are divided.

/// Converts a float to a 32-bit integer as C code does on the processors of LinuxCNC's machines:
/// the fraction is dropped. Values out of range and NaN become [`i32::MIN`].
///
/// ```
/// use hal_component::to_s32;
/// assert_eq!(to_s32(-2.9), -2);
/// assert_eq!(to_s32(3e9), i32::MIN);
/// ```
#[inline]
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "checked before")]
pub const fn to_s32(number: f64) -> i32 {
    let fits = -2_147_483_649.0 < number && number < 2_147_483_648.0;
    if fits { number as i32 } else { i32::MIN }
}

/// Smallest size of a number by which others are divided.
const SMALLEST: f64 = 1e-20;

/// Returns a number by which others can be divided: one that is closer to 0 than 1e-20, or not finite, counts as 1.
///
/// ```
/// use hal_component::divisor;
/// assert_eq!(divisor(-4.0), -4.0);
/// assert_eq!(divisor(0.0), 1.0);
/// ```
#[inline]
#[must_use]
pub const fn divisor(number: f64) -> f64 {
    if number.is_finite() && SMALLEST <= number.abs() { number } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::{divisor, to_s32};

    #[test]
    fn divisors() {
        for (number, is) in [
            (4.0, 4.0),
            (-0.5, -0.5),
            (1e-20, 1e-20),
            (-1e-20, -1e-20),
            (f64::MAX, f64::MAX),
            (9e-21, 1.0),
            (-9e-21, 1.0),
            (f64::MIN_POSITIVE, 1.0),
            (0.0, 1.0),
            (-0.0, 1.0),
            (f64::NAN, 1.0),
            (f64::INFINITY, 1.0),
            (f64::NEG_INFINITY, 1.0),
        ] {
            assert_eq!(divisor(number), is, "{number}");
        }
    }

    #[test]
    fn edges() {
        for (number, is) in [
            (2.9, 2),
            (-2.9, -2),
            (-0.0, 0),
            (f64::MIN_POSITIVE, 0),
            (2_147_483_647.9, i32::MAX),
            (2_147_483_648.0, i32::MIN),
            (-2_147_483_647.9, -i32::MAX),
            (-2_147_483_648.9, i32::MIN),
            (-2_147_483_649.0, i32::MIN),
            (f64::MAX, i32::MIN),
            (f64::NAN, i32::MIN),
            (f64::INFINITY, i32::MIN),
            (f64::NEG_INFINITY, i32::MIN),
        ] {
            assert_eq!(to_s32(number), is, "{number}");
        }
    }
}

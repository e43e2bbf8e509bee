//! Realtime. Conversion of floats to integers.

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

#[cfg(test)]
mod tests {
    use super::to_s32;

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

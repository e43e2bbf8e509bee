//! Realtime. Whole numbers of floats, as LinuxCNC's processors take them.

/// A number without its fraction; one that does not fit, or is none, becomes the lowest.
#[expect(clippy::cast_possible_truncation, reason = "checked before")]
pub(crate) fn whole(number: f64) -> i32 {
    let whole = libm::trunc(number);
    let fits = f64::from(i32::MIN) <= whole && whole <= f64::from(i32::MAX);
    if fits { whole as i32 } else { i32::MIN }
}

#[cfg(test)]
mod tests {
    use super::whole;

    #[test]
    fn edges() {
        for (number, is) in [
            (2.9, 2),
            (-2.9, -2),
            (2_147_483_647.9, i32::MAX),
            (2_147_483_648.0, i32::MIN),
            (-2_147_483_648.9, i32::MIN),
            (f64::NAN, i32::MIN),
            (f64::INFINITY, i32::MIN),
        ] {
            assert_eq!(whole(number), is, "{number}");
        }
    }
}

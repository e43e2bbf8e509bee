//! Durations as users write them.

/// Error for a text that is not a number with a unit, or that exceeds 292 years.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitError;

const UNITS: &[(&str, u64)] =
    &[("ns", 1), ("us", 1_000), ("µs", 1_000), ("ms", 1_000_000), ("s", 1_000_000_000)];

/// Parses `20ms`, `1.5s`, `100 us` to nanoseconds. Refuses fractions of a nanosecond.
///
/// # Errors
/// See [`UnitError`].
pub fn nanoseconds(text: &str) -> Result<u64, UnitError> {
    let text = text.trim();
    let split = text.find(|c: char| !c.is_ascii_digit() && c != '.').ok_or(UnitError)?;
    let (number, unit) = text.split_at_checked(split).ok_or(UnitError)?;
    let scale = UNITS.iter().find(|(u, _)| *u == unit.trim()).ok_or(UnitError)?.1;
    let (whole, part) = number.split_once('.').unwrap_or((number, ""));
    let mut ns = whole.parse::<u64>().ok().and_then(|w| w.checked_mul(scale)).ok_or(UnitError)?;
    let mut place = scale;
    for digit in part.chars() {
        let worth = u64::from(digit.to_digit(10).ok_or(UnitError)?);
        if place < 10 && worth != 0 {
            return Err(UnitError);
        }
        place /= 10;
        ns = ns.checked_add(worth * place).ok_or(UnitError)?;
    }
    if i64::try_from(ns).is_ok() { Ok(ns) } else { Err(UnitError) }
}

/// Writes a duration in the largest unit in which it is at least one.
#[must_use]
pub(crate) fn duration(ns: u64) -> String {
    let units = [("s", 9_u32), ("ms", 6), ("µs", 3)];
    let unit = units.into_iter().find(|(_, digits)| 10_u64.pow(*digits) <= ns);
    let (unit, digits) = unit.unwrap_or(("ns", 0));
    let scale = 10_u64.pow(digits);
    let (whole, part) = (ns / scale, ns % scale);
    let text = format!("{whole}.{part:0width$}", width = digits as usize);
    format!("{} {unit}", text.trim_end_matches('0').trim_end_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::{UnitError, duration, nanoseconds};

    #[test]
    fn a_time_is_a_number_and_a_unit() {
        for (text, want) in [
            ("1s", Ok(1_000_000_000)),
            ("1.5s", Ok(1_500_000_000)),
            ("20ms", Ok(20_000_000)),
            ("20 ms", Ok(20_000_000)),
            ("0.1us", Ok(100)),
            ("100µs", Ok(100_000)),
            ("7ns", Ok(7)),
            ("0s", Ok(0)),
            ("1.0ns", Ok(1)),
            ("0.5ns", Err(UnitError)),
            ("1", Err(UnitError)),
            ("s", Err(UnitError)),
            ("-1s", Err(UnitError)),
            ("1.2.3s", Err(UnitError)),
            ("1min", Err(UnitError)),
            ("99999999999999999999s", Err(UnitError)),
            ("10000000000s", Err(UnitError)),
            ("", Err(UnitError)),
        ] {
            assert_eq!(nanoseconds(text), want, "{text}");
        }
    }

    #[test]
    fn spans_are_told_in_the_largest_unit() {
        for (ns, want) in [
            (0, "0 ns"),
            (999, "999 ns"),
            (1000, "1 µs"),
            (50_000, "50 µs"),
            (100_000_000, "100 ms"),
            (1_050_000, "1.05 ms"),
            (20_000_000_001, "20.000000001 s"),
        ] {
            assert_eq!(duration(ns), want);
            assert_eq!(nanoseconds(&duration(ns)), Ok(ns));
        }
    }
}

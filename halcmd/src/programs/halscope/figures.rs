//! Numbers in readable form.

/// Prefixes of units, by powers of ten.
const PREFIXES: [(f64, &str); 7] =
    [(1e-9, "G"), (1e-6, "M"), (1e-3, "k"), (1.0, ""), (1e3, "m"), (1e6, "µ"), (1e9, "n")];

/// Returns the factor and the unit in which a value of this size is at least one: 0.002 s gives
/// 1000 and ms. Seconds have no larger units.
pub(super) fn unit_of(size: f64, unit: &str) -> (f64, String) {
    let fits = |(factor, prefix): &&(f64, &str)| {
        size * factor >= 0.999_999_999 && !(unit == "s" && *factor < 1.0 && !prefix.is_empty())
    };
    let (factor, prefix) = PREFIXES.iter().find(fits).copied().unwrap_or((1.0, ""));
    (factor, format!("{prefix}{unit}"))
}

/// Writes at most six significant digits, without trailing zeros.
pub(super) fn figures(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e9).contains(&size) {
        let text = format!("{value:.4e}");
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", trimmed(digits));
    }
    let before = 1 + (0..9).take_while(|p| size >= 10_f64.powi(p + 1)).count();
    let small = (1..5).take_while(|p| size < 10_f64.powi(1 - p)).count();
    trimmed(&format!("{value:.*}", (6_usize.saturating_sub(before)) + small)).to_owned()
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::{figures, unit_of};

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (200.0, "200"),
            (199.999_999_9, "200"),
            (-0.5, "-0.5"),
            (1234.5678, "1234.57"),
            (0.001_234_567_8, "0.00123457"),
            (123_456_789.0, "123456789"),
            (1.0e12, "1e12"),
            (-2.5e-7, "-2.5e-7"),
        ] {
            assert_eq!(figures(value), text);
        }
    }

    #[test]
    fn sizes_have_units() {
        for (size, unit, factor, name) in [
            (0.002, "s", 1e3, "ms"),
            (25e-6, "s", 1e6, "µs"),
            (90.0, "s", 1.0, "s"),
            (4000.0, "s", 1.0, "s"),
            (200.0, "Hz", 1.0, "Hz"),
            (20_000.0, "Hz", 1e-3, "kHz"),
            (0.0, "s", 1.0, "s"),
            (5e-10, "s", 1.0, "s"),
        ] {
            assert_eq!(unit_of(size, unit), (factor, name.to_owned()));
        }
    }
}

//! Files of screw errors: `[JOINT_n]COMP_FILE`.

use crate::compensation::{MAX_POINTS, Point, Table};
use hal_component::Error;

/// Reads a file of screw errors. Each line has three numbers: the nominal position, and then for movement in positive
/// and in negative direction either the measured positions (type 0) or the corrections to add (type 1).
pub(crate) fn read(path: &str, holds_corrections: bool) -> Result<Table, Error> {
    let text = std::fs::read(path).map_err(|e| {
        // The reason without the system's number.
        let why = e.to_string();
        let why = why.split(" (os error").next().unwrap_or_default();
        Error::new(format!("comp-file '{path}': {why}"))
    })?;
    parse(&String::from_utf8_lossy(&text), holds_corrections)
        .map_err(|(line, why)| Error::new(format!("comp-file '{path}', line {line}: {why}")))
}

/// Parses the text; an error has the number of its line.
fn parse(text: &str, holds_corrections: bool) -> Result<Table, (usize, String)> {
    let mut points: Vec<Point> = Vec::new();
    for (n, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> =
            line.split('#').next().unwrap_or_default().split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        let numbers: Option<Vec<f64>> =
            words.iter().map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let Some([position, forward, reverse]) = numbers.as_deref() else {
            return Err((n, "expected three numbers: nominal, forward, reverse".to_owned()));
        };
        let (position, forward, reverse) = (*position, *forward, *reverse);
        if points.last().is_some_and(|last| position <= last.position) {
            return Err((n, format!("position {position} is not above the one before it")));
        }
        if points.len() == MAX_POINTS {
            return Err((n, format!("more than {MAX_POINTS} points")));
        }
        let point = if holds_corrections {
            Point { position, forward, reverse }
        } else {
            Point { position, forward: position - forward, reverse: position - reverse }
        };
        points.push(point);
    }
    if points.is_empty() {
        return Err((1, "no point".to_owned()));
    }
    Ok(Table(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_types() {
        let text = "# nominal forward reverse\n-10 -10.5 -9.75\n\n20\t20.25 20.5 # end\n";
        let of = |position, forward, reverse| Point { position, forward, reverse };
        let measured = vec![of(-10.0, 0.5, -0.25), of(20.0, -0.25, -0.5)];
        assert_eq!(parse(text, false), Ok(Table(measured)));
        let given = vec![of(-10.0, -10.5, -9.75), of(20.0, 20.25, 20.5)];
        assert_eq!(parse(text, true), Ok(Table(given)));
    }

    #[test]
    fn errors_name_the_line() {
        let many: String = (0..=MAX_POINTS).map(|n| format!("{n} {n} {n}\n")).collect();
        let three = "expected three numbers: nominal, forward, reverse";
        for (text, line, why) in [
            ("", 1, "no point"),
            ("\n1 2\n", 2, three),
            ("1 2 3 4", 1, three),
            ("1 2 x", 1, three),
            ("1 nan 2", 1, three),
            ("1 1 1\n1 2 2", 2, "position 1 is not above the one before it"),
            (&many, MAX_POINTS + 1, "more than 256 points"),
        ] {
            assert_eq!(parse(text, true), Err((line, why.to_owned())), "{text}");
        }
    }
}

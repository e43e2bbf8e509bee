//! Files of screw errors: `[JOINT_n]COMP_FILE`.

use crate::compensation::{MAX_POINTS, Point, Table};
use hal_component::Error;
use std::{fs::File, io::Read};

/// Maximum length of a file: far more than its points need.
const MAX_BYTES: u64 = 1 << 20;

/// Reads a file of screw errors. Each line has three numbers: the nominal position, and then for movement in positive
/// and in negative direction either the measured positions (type 0) or the corrections to add (type 1).
pub(crate) fn read(path: &str, holds_corrections: bool) -> Result<Table, Error> {
    let text = bytes(path).map_err(|e| {
        // The reason without the system's number.
        let why = e.to_string();
        let why = why.split(" (os error").next().unwrap_or_default();
        Error::new(format!("comp-file '{path}': {why}"))
    })?;
    parse(&String::from_utf8_lossy(&text), holds_corrections)
        .map_err(|(line, why)| Error::new(format!("comp-file '{path}', line {line}: {why}")))
}

/// Reads a regular file of at most [`MAX_BYTES`]: a pipe could hold up every command, and a device would never end.
fn bytes(path: &str) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    let mut text = Vec::new();
    let n = File::open(path)?.take(MAX_BYTES + 1).read_to_end(&mut text)?;
    if n as u64 > MAX_BYTES {
        return Err(std::io::Error::other(format!("longer than {MAX_BYTES} bytes")));
    }
    Ok(text)
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
    fn only_a_regular_file_of_bounded_length_is_read() {
        let said = |path: &str| bytes(path).unwrap_err().to_string();
        assert_eq!(said("/dev/zero"), "not a regular file");
        assert!(said("/nonexistent").starts_with("No such file or directory"));
        let path = std::env::temp_dir().join(format!("hal-comp-file-{}", std::process::id()));
        std::fs::write(&path, vec![b'\n'; 1 + (1 << 20)]).unwrap();
        assert_eq!(said(path.to_str().unwrap()), "longer than 1048576 bytes");
        std::fs::remove_file(&path).unwrap();
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

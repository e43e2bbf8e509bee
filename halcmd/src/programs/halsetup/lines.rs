//! Lines of the board: their texts, and which of them are inputs and outputs.

use super::sheet::Sheet;
use std::collections::{BTreeMap, BTreeSet};

/// A line of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Line {
    pub(super) port: usize,
    pub(super) number: u8,
    pub(super) is_inverted: bool,
}

/// Direction of a line, seen from the computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LineWay {
    In,
    Out,
}

impl LineWay {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::In => "input",
            Self::Out => "output",
        }
    }
}

impl Line {
    /// Returns the text of the line without its inversion: `6`, `1.11`.
    pub(super) fn text(self) -> String {
        match self.port {
            0 => self.number.to_string(),
            port => format!("{port}.{}", self.number),
        }
    }
}

/// Reads a line: `6`, `1.11` on the second port, `!6` inverted.
pub(super) fn line(text: &str) -> Option<Line> {
    let (is_inverted, rest) = text.strip_prefix('!').map_or((false, text), |rest| (true, rest));
    let (port, number) = rest.split_once('.').unwrap_or(("0", rest));
    let number: u8 = number.parse().ok()?;
    Some(Line { port: port.parse().ok()?, number, is_inverted })
        .filter(|l| (1..=40).contains(&l.number))
}

/// Returns the lines of a way that a parallel port has in a mode.
fn of_port(mode: &str, way: LineWay) -> &'static [u8] {
    match (mode, way) {
        ("in", LineWay::Out) => &[1, 14, 16, 17],
        ("in", LineWay::In) => &[2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15],
        ("x", LineWay::Out) => &[2, 3, 4, 5, 6, 7, 8, 9],
        ("x", LineWay::In) => &[1, 10, 11, 12, 13, 14, 15, 16, 17],
        (_, LineWay::Out) => &[1, 2, 3, 4, 5, 6, 7, 8, 9, 14, 16, 17],
        (_, LineWay::In) => &[10, 11, 12, 13, 15],
    }
}

/// Returns the lines of a way that the board of the answers has, as port and number.
pub(super) fn lines(sheet: &Sheet, way: LineWay) -> BTreeSet<(usize, u8)> {
    if sheet.get("driver") == Some("viagpio") {
        let numbers = if way == LineWay::In { 1..=4 } else { 5..=8 };
        return numbers.map(|n| (0, n)).collect();
    }
    let ports = sheet.get("ports").unwrap_or("378 out").split(',').map(str::trim);
    let of = |(n, port): (usize, &str)| {
        let mode = port.split_whitespace().nth(1).unwrap_or("out").to_owned();
        of_port(&mode, way).iter().map(move |number| (n, *number)).collect::<Vec<_>>()
    };
    ports.enumerate().flat_map(of).collect()
}

/// Returns the lines that have a use, with the keys of their questions.
pub(super) fn used(sheet: &Sheet) -> BTreeMap<(usize, u8), String> {
    let is_line = |key: &str| super::questions::is_line(key);
    let each = sheet.iter().filter(|(key, _)| is_line(key));
    each.filter_map(|(key, text)| line(text).map(|l| ((l.port, l.number), key.to_owned())))
        .collect()
}

/// Returns the lines of a way that have no use yet, as a person types them.
pub(super) fn free(sheet: &Sheet, way: LineWay) -> String {
    let used = used(sheet);
    let free = lines(sheet, way).into_iter().filter(|line| !used.contains_key(line));
    let texts: Vec<String> =
        free.map(|(port, number)| Line { port, number, is_inverted: false }.text()).collect();
    if texts.is_empty() { "none is free".to_owned() } else { texts.join(", ") }
}

/// Returns why a text is no line of this way that is free.
pub(super) fn refuse(sheet: &Sheet, key: &str, text: &str, way: LineWay) -> Option<String> {
    let free = || free(sheet, way);
    let word = way.word();
    let Some(given) = line(text) else {
        return Some(format!(
            "'{text}' is no line: a number as 6, 1.11 on the second port, !6 inverted; free {word}s: {}",
            free()
        ));
    };
    let at = (given.port, given.number);
    if lines(sheet, way).contains(&at) {
        let other = used(sheet).get(&at).filter(|other| *other != key).cloned();
        return other.map(|other| {
            format!(
                "line {} is used by {} already; free {word}s: {}",
                given.text(),
                super::questions::spoken(sheet, &other),
                free()
            )
        });
    }
    let other = if way == LineWay::In { LineWay::Out } else { LineWay::In };
    Some(if lines(sheet, other).contains(&at) {
        format!(
            "line {} is an {}, and this wants an {word}; free {word}s: {}",
            given.text(),
            other.word(),
            free()
        )
    } else {
        format!("the board has no line {}; free {word}s: {}", given.text(), free())
    })
}

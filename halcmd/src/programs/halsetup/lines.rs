//! Lines of the board: their texts, and that each has one use.

use super::answers::{Answers, Driver, Wrong};
use std::collections::BTreeMap;

/// A line of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Line {
    pub(super) port: usize,
    pub(super) number: u8,
    pub(super) is_inverted: bool,
}

/// Reads a line: `6`, `1.11` on the second port, `!6` inverted.
pub(super) fn line(text: &str) -> Option<Line> {
    let (is_inverted, rest) = text.strip_prefix('!').map_or((false, text), |rest| (true, rest));
    let (port, number) = rest.split_once('.').unwrap_or(("0", rest));
    let number: u8 = number.parse().ok()?;
    Some(Line { port: port.parse().ok()?, number, is_inverted })
        .filter(|l| (1..=40).contains(&l.number))
}

/// Checks that each line is one of the board's, and has one use.
pub(super) fn are_used_once(answers: &Answers, wrong: &mut Vec<Wrong>) {
    let ports = if answers.driver == Driver::Parport { answers.ports.get_ref().len() } else { 1 };
    let mut used: BTreeMap<(usize, u8), String> = BTreeMap::new();
    let pins = &answers.pins;
    let whole = [
        ("pins.estop", &pins.estop),
        ("pins.enable", &pins.enable),
        ("pins.spindle", &pins.spindle),
    ];
    let whole = whole.into_iter().map(|(key, text)| (0, key.to_owned(), text));
    let joints = answers.joint.iter().enumerate().flat_map(|(n, joint)| {
        let (at, j) = (joint.span().start, joint.get_ref());
        [
            ("step", &j.step),
            ("direction", &j.direction),
            ("switch", &j.switch),
            ("a", &j.a),
            ("b", &j.b),
        ]
        .map(|(key, text)| (at, format!("{key} of joint {n}"), text))
    });
    for (at, key, text) in whole.chain(joints) {
        let Some(text) = text else { continue };
        let Some(line) = line(text).filter(|l| l.port < ports) else {
            let text = format!(
                "{key} '{text}': a number as '6', or PORT.NUMBER as '1.11'; '!' before it inverts"
            );
            wrong.push(Wrong { at, text });
            continue;
        };
        if let Some(other) = used.insert((line.port, line.number), key.clone()) {
            wrong.push(Wrong { at, text: format!("{key} and {other} are both on line {text}") });
        }
    }
}

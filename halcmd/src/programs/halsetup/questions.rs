//! The questions that answers lead to: one sequence for the terminal, for the file of answers, and for the tests.

use super::{
    boards::{board, preset},
    lines::{LineWay, free},
    sheet::Sheet,
    tables::{JOINT, MOTOR, PINS, PULSE, RANGE, SEARCH, SERVO, SPINDLE, TABLES, WHOLE},
};

/// Bounds of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Range {
    /// From one number to another.
    Within(f64, f64),
    /// A length or an angle of either sign.
    Signed,
    /// A number above 0.
    Positive,
    /// A number above 0, or nothing.
    PositiveOrNone,
}

/// Form of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Form {
    /// Name of a machine.
    Name,
    Number(Range),
    /// A word of a list.
    OneOf(&'static [&'static str]),
    /// Addresses and modes of parallel ports.
    Ports,
    /// Letters of axes.
    Axes,
    /// Letter of an axis with two motors, or nothing.
    Gantry,
    /// A line of the board, or nothing.
    Input,
    Output,
}

/// A question: its key in its table, its text, its unit, an empty answer's meaning, and its help. `{u}` is the unit of
/// length of the machine, or degrees.
#[derive(Debug, PartialEq)]
pub(super) struct Question {
    pub(super) key: &'static str,
    pub(super) text: &'static str,
    pub(super) unit: &'static str,
    pub(super) default: &'static str,
    pub(super) form: Form,
    /// True if a file must have the answer.
    pub(super) is_needed: bool,
    pub(super) help: &'static str,
}

/// A question in its place.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    pub(super) key: String,
    /// Part that it is asked of: `X`, `joint 2`; empty for the whole machine.
    pub(super) of: String,
    pub(super) question: &'static Question,
    pub(super) unit: String,
    /// Answer of the board, or nothing.
    pub(super) preset: &'static str,
    /// Answer that an empty line gives; empty for none.
    pub(super) default: String,
}

/// Returns whether the answer to the question with this key is a line of the board.
pub(super) fn is_line(key: &str) -> bool {
    let name = key.rsplit('.').next().unwrap_or(key);
    let all = TABLES.iter().flat_map(|(_, questions)| *questions);
    key.contains('.')
        && all.filter(|q| q.key == name).any(|q| matches!(q.form, Form::Input | Form::Output))
        && !key.starts_with("spindle.")
}

/// Returns a key as a person says it: `step of X`.
pub(super) fn spoken(sheet: &Sheet, key: &str) -> String {
    let words: Vec<&str> = key.split('.').collect();
    match words.as_slice() {
        ["joint", n, name] => format!("{name} of {}", of_joint(sheet, n.parse().unwrap_or(0))),
        [_, name] => (*name).to_owned(),
        _ => key.to_owned(),
    }
}

/// Returns the name of a joint: the letter of its axis, with a number for the second motor of a gantry.
pub(super) fn of_joint(sheet: &Sheet, n: usize) -> String {
    if sheet.get("kind") == Some("arm") {
        return format!("joint {n}");
    }
    let letters = sheet.letters();
    let Some(letter) = letters.get(n) else { return format!("joint {n}") };
    if is_second(sheet, n) { format!("{letter}2") } else { letter.to_string() }
}

/// Returns whether a joint is the second motor of a gantry.
pub(super) fn is_second(sheet: &Sheet, n: usize) -> bool {
    let letters = sheet.letters();
    n > 0 && sheet.get("kind") != Some("arm") && letters.get(n - 1) == letters.get(n)
}

/// Returns the number of joints.
pub(super) fn joints(sheet: &Sheet) -> usize {
    if sheet.get("kind") == Some("arm") { 6 } else { sheet.letters().len() }
}

/// Returns the questions that the answers so far lead to. Later answers never change earlier questions.
pub(super) fn sequence(sheet: &Sheet) -> Vec<Asked> {
    let mut to = Vec::new();
    let is = |key: &str, word: &str| sheet.get(key) == Some(word);
    for question in WHOLE {
        let applies = match question.key {
            "ports" => is("driver", "parport"),
            "model" => is("kind", "arm"),
            "gantry" => !is("kind", "arm"),
            _ => true,
        };
        if applies {
            add(&mut to, sheet, "", "", question);
        }
    }
    if to.iter().any(|asked| sheet.get(&asked.key).is_none()) {
        return to;
    }
    for question in PINS {
        let applies = question.key != "spindle-reverse" || sheet.some("pins.spindle").is_some();
        if applies {
            add(&mut to, sheet, "pins.", "", question);
        }
    }
    if sheet.some("pins.spindle-pwm").is_some() {
        SPINDLE.iter().for_each(|q| add(&mut to, sheet, "spindle.", "", q));
    }
    if !is("kind", "servos") {
        PULSE.iter().for_each(|q| add(&mut to, sheet, "pulse.", "", q));
    }
    if is("kind", "arm") {
        for (n, letter) in sheet.letters().iter().enumerate() {
            let (key, of) = (format!("axis.{n}."), letter.to_string());
            RANGE.iter().for_each(|q| add(&mut to, sheet, &key, &of, q));
        }
    }
    for n in 0..joints(sheet) {
        let (key, of) = (format!("joint.{n}."), of_joint(sheet, n));
        let mut ask = |questions: &'static [Question]| {
            questions.iter().for_each(|q| add(&mut to, sheet, &key, &of, q));
        };
        let is_second = is_second(sheet, n);
        if !is_second {
            ask(RANGE);
            JOINT
                .iter()
                .filter(|q| q.key != "drive-acceleration" || !is("kind", "servos"))
                .for_each(|q| add(&mut to, sheet, &key, &of, q));
        }
        MOTOR.iter().for_each(|q| add(&mut to, sheet, &key, &of, q));
        if !is_second && sheet.some(&format!("{key}switch")).is_some() {
            add(&mut to, sheet, &key, &of, &SEARCH);
        }
        if is("kind", "servos") {
            let questions = SERVO.iter().filter(|q| q.key != "full-speed" || !is_second);
            questions.for_each(|q| add(&mut to, sheet, &key, &of, q));
        }
    }
    to
}

fn add(to: &mut Vec<Asked>, sheet: &Sheet, before: &str, of: &str, question: &'static Question) {
    let key = format!("{before}{}", question.key);
    let preset = board(sheet.get("board")).map_or("", |board| preset(board, &key));
    let is_turning = before.starts_with("joint.") && sheet.get("kind") == Some("arm")
        || of.chars().next().is_some_and(|c| "ABC".contains(c)) && of.len() < 3;
    let unit = if is_turning { "degrees" } else { sheet.get("units").unwrap_or("mm") };
    let unit = question.unit.replace("{u}", unit);
    let default = default(sheet, &key, question, preset, &unit);
    to.push(Asked { key, of: of.to_owned(), question, unit, preset, default });
}

/// Returns the answer that an empty line gives: that of the board if it is free, or one that suits the answers before it.
fn default(sheet: &Sheet, key: &str, question: &Question, preset: &str, unit: &str) -> String {
    let number = |name: &str| {
        let before = key.rsplit_once('.').map_or("", |(before, _)| before);
        sheet.number(&format!("{before}.{name}"))
    };
    let is_turning = unit == "degrees";
    let is_inch = unit.starts_with("inch");
    match question.key {
        _ if !preset.is_empty() => {
            let way = match question.form {
                Form::Input => LineWay::In,
                Form::Output => LineWay::Out,
                _ => return preset.to_owned(),
            };
            let is_free = super::lines::refuse(sheet, key, preset, way).is_none();
            if is_free { preset.to_owned() } else { String::new() }
        }
        "latency" => {
            let longest = board(sheet.get("board")).map_or(100_000.0, |board| board.longest);
            if longest < 100_000.0 { "20000" } else { question.default }.to_owned()
        }
        "min" if is_inch => "-4".to_owned(),
        "velocity" if is_inch => "2".to_owned(),
        "acceleration" if is_inch => "20".to_owned(),
        "pitch" if is_inch => "0.2".to_owned(),
        "max" if is_inch && number("min").is_some_and(|min| min < 4.0) => "4".to_owned(),
        "max" => number("min")
            .filter(|min| *min >= 100.0)
            .map_or("100".to_owned(), |m| format!("{:?}", m + 100.0)),
        "pitch" if is_turning => "360".to_owned(),
        "home" => {
            let (min, max) = (number("min").unwrap_or(0.0), number("max").unwrap_or(0.0));
            let home = if min <= 0.0 && 0.0 <= max { 0.0 } else { min };
            format!("{home:?}").trim_end_matches(".0").to_owned()
        }
        "search" => {
            let velocity = number("velocity").unwrap_or(5.0);
            let search = if velocity < 5.0 { velocity } else { 5.0 };
            format!("{:?}", -search).trim_end_matches(".0").to_owned()
        }
        "full-speed" => {
            let velocity = number("velocity").unwrap_or(50.0);
            format!("{:?}", 2.0 * velocity).trim_end_matches(".0").to_owned()
        }
        _ => question.default.to_owned(),
    }
}

impl Asked {
    /// Returns whether "none" is an answer.
    pub(super) fn may_be_none(&self) -> bool {
        match self.question.form {
            Form::Input | Form::Output => !self.question.is_needed,
            Form::Number(range) => range == Range::PositiveOrNone,
            Form::Gantry => true,
            Form::Name | Form::OneOf(_) | Form::Ports | Form::Axes => false,
        }
    }

    /// Returns what the question accepts, in words.
    pub(super) fn accepts(&self, sheet: &Sheet) -> String {
        let none = if self.may_be_none() { "; none" } else { "" };
        let way = |way: LineWay| format!("{} {}{none}", way.word(), free(sheet, way));
        match self.question.form {
            Form::Name => "letters, digits, '-' and '_'".to_owned(),
            Form::Number(Range::Within(least, most)) => format!("{least} to {most}"),
            Form::Number(Range::Signed) => self.of_either_sign(sheet),
            Form::Number(Range::Positive | Range::PositiveOrNone) => format!("above 0{none}"),
            Form::OneOf(words) => words.join(", "),
            Form::Ports => "as 378 out, 278 in".to_owned(),
            Form::Axes => "of X Y Z A B C U V W".to_owned(),
            Form::Gantry => format!("one of {}; none", sheet.get("axes").unwrap_or("XYZ")),
            Form::Input => way(LineWay::In),
            Form::Output => way(LineWay::Out),
        }
    }

    /// Returns the bounds of a length or angle, which other answers of its joint or axis set.
    fn of_either_sign(&self, sheet: &Sheet) -> String {
        let table = self.key.rsplit_once('.').map_or("", |(table, _)| table);
        let number = |name: &str| sheet.number(&format!("{table}.{name}")).unwrap_or_default();
        match self.question.key {
            "max" => format!("above {}", number("min")),
            "home" => format!("{} to {}", number("min"), number("max")),
            "search" => format!("not 0, at most {} to either side", number("velocity")),
            _ => "a number, negative too".to_owned(),
        }
    }

    /// Returns the prompt.
    pub(super) fn prompt(&self, sheet: &Sheet) -> String {
        let of = if self.of.is_empty() { String::new() } else { format!("{}: ", self.of) };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" in {}", self.unit) };
        let default = match (self.default.as_str(), self.may_be_none()) {
            ("", true) => " [none]".to_owned(),
            ("", false) => String::new(),
            (default, _) => format!(" [{default}]"),
        };
        format!("{of}{}{unit} ({}){default}: ", self.question.text, self.accepts(sheet))
    }
}

/// Largest magnitude of lengths, speeds, accelerations and ratios.
pub(super) const LARGEST: f64 = 1e9;
/// Smallest of them that is not 0: the files have nine decimals.
pub(super) const SMALLEST: f64 = 1e-6;

//! Answers of a file: read as a person gives them, in the order of the questions.

use super::{
    answers::Answers,
    questions::{Asked, Form, is_second, joints, sequence},
    rules::refusal,
    sheet::{Sheet, UNFINISHED, Value, ValueKind, Wrong, values},
    tables::TABLES,
};
use std::collections::BTreeMap;

/// Answers of a file: those that are good, whether the file says that it is not answered to the end, and what is wrong.
#[derive(Debug, Default)]
pub(super) struct Given {
    pub(super) sheet: Sheet,
    pub(super) is_unfinished: bool,
    /// True if all that is wrong is that questions lack an answer.
    pub(super) only_lacks: bool,
    pub(super) wrong: Vec<Wrong>,
    /// Answers in `sheet` that the file does not have, and that the terminal would ask for.
    pub(super) assumed: Vec<String>,
}

/// Reads answers and checks that they make a machine. The error has the line and all that is wrong with it.
pub(super) fn read(text: &str) -> Result<Answers, Vec<Wrong>> {
    let given = given(text)?;
    if given.wrong.is_empty() { Ok(Answers::of(&given.sheet)) } else { Err(given.wrong) }
}

/// Reads answers as a person gives them: in the order of the questions, each judged when it is given.
pub(super) fn given(text: &str) -> Result<Given, Vec<Wrong>> {
    let mut values = values(text)?;
    let mut to = Given { only_lacks: true, ..Given::default() };
    to.is_unfinished = values.remove(UNFINISHED).is_some_and(|v| v.text == "true");
    let tables: BTreeMap<String, usize> = values
        .iter()
        .filter(|(key, v)| v.kind == ValueKind::List && key.contains('.'))
        .map(|(key, v)| (key.clone(), v.at))
        .collect();
    values.retain(|key, _| !tables.contains_key(key));
    let say = |to: &mut Given, at, text: String| {
        to.only_lacks = false;
        to.wrong.push(Wrong { at, text });
    };
    for (at, text) in letters(&mut values, &tables) {
        say(&mut to, at, text);
    }
    loop {
        let asked = sequence(&to.sheet).into_iter().find(|a| to.sheet.get(&a.key).is_none());
        let Some(asked) = asked else { break };
        let answer = match values.remove(&asked.key) {
            Some(value) if value.suits(&asked) => {
                let why = refusal(&to.sheet, &asked, &value.text);
                if let Some(text) = &why {
                    say(&mut to, value.at, placed(&asked, text));
                }
                why.is_none().then_some(value.text)
            }
            Some(value) => {
                let text = match asked.question.form {
                    Form::Number(_) => "a number, without quotes",
                    Form::Ports => "a list of texts, as [\"378 out\"]",
                    _ => "a text in quotes",
                };
                say(&mut to, value.at, format!("{}: {text}", asked.key));
                None
            }
            None => {
                // A table that is not there lacks each of its answers: it is reported once, below.
                if !to.is_unfinished && has_table(&asked, &tables) {
                    let refused = refusal(&to.sheet, &asked, &asked.default);
                    match refused.filter(|_| !asked.question.is_needed) {
                        Some(text) => {
                            let at = table_of(&asked, &tables);
                            to.wrong.push(Wrong { at, text: placed(&asked, &text) });
                        }
                        None if asked.question.is_needed => to.wrong.push(lacks(&asked, &tables)),
                        None => {}
                    }
                }
                to.assumed.push(asked.key.clone());
                None
            }
        };
        let answer = answer.unwrap_or_else(|| {
            // What follows is judged with an answer that is possible; it is not used.
            let is_good = |text: &&str| refusal(&to.sheet, &asked, text).is_none();
            let each = [asked.default.as_str(), "", "1", "0", "10000"];
            each.into_iter().find(is_good).unwrap_or("1").to_owned()
        });
        to.sheet.put(&asked.key, &answer);
    }
    for (array, needed) in [("joint", joints(&to.sheet)), ("axis", axes(&to.sheet))] {
        let found = tables.keys().filter(|key| key.starts_with(&format!("{array}."))).count();
        if found < needed && to.wrong.is_empty() && !to.is_unfinished {
            let of = if to.sheet.get("kind") == Some("arm") {
                "an arm"
            } else {
                "a machine with these axes"
            };
            to.wrong
                .push(Wrong { at: 0, text: format!("{of} has {needed} [[{array}]], not {found}") });
        }
    }
    for (key, value) in values {
        let text = stray(&to.sheet, &key);
        say(&mut to, value.at, text);
    }
    to.wrong.sort_by_key(|wrong| wrong.at);
    Ok(to)
}

/// Returns a refusal with the key that it is about, unless it names it.
fn placed(asked: &Asked, text: &str) -> String {
    let name = asked.question.key;
    if text.starts_with(name) { text.to_owned() } else { format!("{name}: {text}") }
}

/// Returns the number of tables of axes.
fn axes(sheet: &Sheet) -> usize {
    if sheet.get("kind") == Some("arm") { sheet.letters().len() } else { 0 }
}

/// Returns whether the table of an answer is in the file.
fn has_table(asked: &Asked, tables: &BTreeMap<String, usize>) -> bool {
    let table = asked.key.rsplit_once('.').map_or("", |(table, _)| table);
    !table.contains('.') || tables.contains_key(table)
}

fn lacks(asked: &Asked, tables: &BTreeMap<String, usize>) -> Wrong {
    let (name, text) = (asked.question.key, asked.question.text);
    Wrong { at: table_of(asked, tables), text: format!("{name} is missing: {text}") }
}

/// Returns where the table of an answer is.
fn table_of(asked: &Asked, tables: &BTreeMap<String, usize>) -> usize {
    let table = asked.key.rsplit_once('.').map_or("", |(table, _)| table);
    tables.get(table).copied().unwrap_or_default()
}

/// Takes the letters of the tables out of the values, and makes `axes` and `gantry` of them where a file has none.
fn letters(
    values: &mut BTreeMap<String, Value>,
    tables: &BTreeMap<String, usize>,
) -> Vec<(usize, String)> {
    let is_arm = values.get("kind").is_some_and(|v| v.text == "arm");
    let (array, name) = if is_arm { ("axis", "letter") } else { ("joint", "axis") };
    let mut wrong = Vec::new();
    let (mut found, mut at) = (Vec::new(), 0);
    for n in 0..tables.len() {
        let Some(value) = values.remove(&format!("{array}.{n}.{name}")) else { continue };
        let mut each = value.text.chars();
        match (each.next(), each.next()) {
            (Some(letter), None) => found.push(letter),
            _ => wrong.push((value.at, format!("axis '{}': one of X Y Z A B C U V W", value.text))),
        }
        at = value.at;
    }
    let mut axes = String::new();
    let mut twice = String::new();
    for (n, letter) in found.iter().enumerate() {
        if n > 0 && found.get(n - 1) == Some(letter) && twice.is_empty() && !is_arm {
            twice.push(*letter);
        } else {
            axes.push(*letter);
        }
    }
    let made = |text: &str| Value { text: text.to_owned(), kind: ValueKind::Text, at };
    match values.get("axes") {
        None if !axes.is_empty() => {
            values.insert("axes".to_owned(), made(&axes));
            if !is_arm {
                values.entry("gantry".to_owned()).or_insert_with(|| made(&twice));
            }
        }
        Some(given) if !found.is_empty() => {
            let gantry = values.get("gantry").map_or("", |v| v.text.as_str());
            let all: String = given
                .text
                .chars()
                .flat_map(|c| std::iter::repeat_n(c, 1 + usize::from(gantry.contains(c))))
                .collect();
            let is_one: String = found.iter().collect();
            if !all.starts_with(&is_one) {
                wrong.push((at, format!("the axes are {all}, and the tables have {is_one}")));
            }
        }
        _ => {}
    }
    wrong
}

/// Returns why a key answers no question of this machine.
fn stray(sheet: &Sheet, key: &str) -> String {
    let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
    let kind = table.split('.').next().unwrap_or_default();
    let is_arm = sheet.get("kind") == Some("arm");
    let n: usize = table.rsplit('.').next().and_then(|n| n.parse().ok()).unwrap_or(0);
    let known = TABLES
        .iter()
        .filter(|(t, _)| *t == kind || *t == "range" && ["joint", "axis"].contains(&kind));
    let names: Vec<&str> = known.flat_map(|(_, list)| list.iter().map(|q| q.key)).collect();
    match (kind, name) {
        ("axis", _) if !is_arm => "[[axis]] is for arms; here each [[joint]] is an axis".to_owned(),
        ("joint", "axis") => "axis: a joint of an arm is no axis".to_owned(),
        ("joint", _) if n >= joints(sheet) => {
            format!("the machine has {} joints: this one is too many", joints(sheet))
        }
        ("joint", "a" | "b" | "full-speed") => format!("{name} is for servos"),
        ("joint", "search") => "search: homing needs switch, the input to look for".to_owned(),
        ("joint", _) if is_second(sheet, n) && names.contains(&name) => {
            format!("{name}: the second motor of a gantry has that of the first")
        }
        ("joint" | "pulse", "drive-acceleration" | "length" | "space" | "hold" | "setup") => {
            format!("{name} is for stepper motors")
        }
        ("pins", "spindle-reverse") => "spindle-reverse needs spindle".to_owned(),
        ("spindle", "speed" | "frequency") => format!("{name} needs pins.spindle-pwm"),
        ("", "model") => "model is for arms".to_owned(),
        ("", "ports") => "ports is for parport".to_owned(),
        ("", "gantry") => "gantry: an arm has none".to_owned(),
        _ => format!("unknown '{name}', expected one of: {}", names.join(", ")),
    }
}

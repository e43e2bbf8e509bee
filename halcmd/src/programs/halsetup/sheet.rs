//! Answers by the keys of their questions, and the TOML text that keeps them.

use super::questions::{Asked, Form, sequence};
use std::{collections::BTreeMap, fmt::Write as _};
use toml::de::{DeTable, DeValue};

/// Largest number of tables in an array of the text.
const MAX_TABLES: usize = 64;
/// Key of an answers file whose questions are not answered to the end.
pub(super) const UNFINISHED: &str = "unfinished";

/// An answer that cannot be: the byte at which it stands, and what is wrong with it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    pub(super) at: usize,
    pub(super) text: String,
}

/// Kind of a value in the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueKind {
    Number,
    Text,
    List,
    Bool,
}

/// A value of the text: what it says, its kind, and the byte at which it stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Value {
    pub(super) text: String,
    pub(super) kind: ValueKind,
    pub(super) at: usize,
}

/// Answers by key: `name`, `pins.estop`, `joint.0.step`. An empty text is the answer "none".
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Sheet(BTreeMap<String, String>);

impl Sheet {
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    /// Returns an answer that is not "none".
    pub(super) fn some(&self, key: &str) -> Option<&str> {
        self.get(key).filter(|text| !text.is_empty())
    }

    pub(super) fn number(&self, key: &str) -> Option<f64> {
        number(self.get(key)?)
    }

    pub(super) fn put(&mut self, key: &str, answer: &str) {
        self.0.insert(key.to_owned(), answer.to_owned());
    }

    pub(super) fn remove(&mut self, key: &str) -> Option<String> {
        self.0.remove(key)
    }

    /// Returns the answers with their keys.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(key, text)| (key.as_str(), text.as_str()))
    }

    /// Returns the letters of the axes, one for each joint: that of a gantry is there twice.
    pub(super) fn letters(&self) -> Vec<char> {
        let gantry = self.some("gantry").unwrap_or_default();
        let each = self.get("axes").unwrap_or_default().chars();
        each.flat_map(|c| std::iter::repeat_n(c, 1 + usize::from(gantry.contains(c)))).collect()
    }

    /// Returns the TOML text of the answers, in the order of the questions.
    pub(super) fn text(&self, is_finished: bool) -> String {
        let mut to = String::from("# Answers for halsetup.\n");
        if !is_finished {
            let _: std::fmt::Result = writeln!(to, "{UNFINISHED} = true");
        }
        let mut begun = String::new();
        for asked in sequence(self) {
            let Some(answer) = self.get(&asked.key) else { continue };
            let (table, name) = asked.key.rsplit_once('.').unwrap_or(("", &asked.key));
            if table != begun {
                head(&mut to, table, self);
                table.clone_into(&mut begun);
            }
            if answer.is_empty() && is_finished && asked.preset.is_empty() {
                continue;
            }
            let value = match asked.question.form {
                Form::Number(_) if !answer.is_empty() => answer.to_owned(),
                Form::Ports => {
                    let ports = answer.split(',').map(|p| toml::Value::from(p.trim()));
                    toml::Value::Array(ports.collect()).to_string()
                }
                _ => toml::Value::from(answer).to_string(),
            };
            let _: std::fmt::Result = writeln!(to, "{name} = {value}");
        }
        to
    }
}

/// Appends the head of a table: `[pins]`, or `[[joint]]` with the letter of its axis.
fn head(to: &mut String, table: &str, sheet: &Sheet) {
    let _: std::fmt::Result = match table.split_once('.') {
        None => write!(to, "\n[{table}]\n"),
        Some(("axis", n)) => {
            let letter = n.parse().ok().and_then(|n: usize| sheet.letters().get(n).copied());
            write!(to, "\n[[axis]]\nletter = \"{}\"\n", letter.unwrap_or_default())
        }
        Some((array, n)) => {
            let _: std::fmt::Result = write!(to, "\n[[{array}]]\n");
            let letter = n.parse().ok().and_then(|n: usize| sheet.letters().get(n).copied());
            match letter.filter(|_| sheet.get("kind") != Some("arm")) {
                Some(letter) => writeln!(to, "axis = \"{letter}\""),
                None => Ok(()),
            }
        }
    };
}

/// Reads a number as TOML has it, without blanks.
pub(super) fn number(text: &str) -> Option<f64> {
    let is_toml = toml::from_str::<toml::Table>(&format!("x = {text}"));
    let value = is_toml.ok().filter(|_| !text.contains(['\n', '#']))?.remove("x")?;
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

/// Reads the values of a text by their keys.
pub(super) fn values(text: &str) -> Result<BTreeMap<String, Value>, Vec<Wrong>> {
    let table = DeTable::parse(text).map_err(|e| {
        let at = e.span().map_or(0, |s| s.start);
        vec![Wrong { at, text: e.message().to_owned() }]
    })?;
    let (mut to, mut wrong) = (BTreeMap::new(), Vec::new());
    flatten("", table.get_ref(), text, &mut to, &mut wrong);
    if wrong.is_empty() { Ok(to) } else { Err(wrong) }
}

fn flatten(
    before: &str,
    table: &DeTable<'_>,
    source: &str,
    to: &mut BTreeMap<String, Value>,
    wrong: &mut Vec<Wrong>,
) {
    for (name, value) in table {
        let key = format!("{before}{}", name.get_ref());
        let at = name.span().start;
        let plain = |text: String, kind| Value { text, kind, at };
        let slice = || source.get(value.span()).unwrap_or_default().replace('_', "");
        match value.get_ref() {
            DeValue::Table(inner) => flatten(&format!("{key}."), inner, source, to, wrong),
            DeValue::Array(list) if list.iter().all(|v| v.get_ref().is_table()) => {
                for (n, inner) in list.iter().take(MAX_TABLES).enumerate() {
                    let key = format!("{key}.{n}");
                    // The table itself, so that one without keys is there.
                    to.insert(
                        key.clone(),
                        Value {
                            text: String::new(),
                            kind: ValueKind::List,
                            at: inner.span().start,
                        },
                    );
                    if let Some(inner) = inner.get_ref().as_table() {
                        flatten(&format!("{key}."), inner, source, to, wrong);
                    }
                }
            }
            DeValue::Array(list) => {
                let texts: Option<Vec<&str>> = list
                    .iter()
                    .map(|v| v.get_ref().as_str().filter(|t| !t.contains(',')))
                    .collect();
                match texts {
                    Some(texts) => {
                        to.insert(key, plain(texts.join(", "), ValueKind::List));
                    }
                    None => wrong.push(Wrong { at, text: format!("{key}: a list of texts") }),
                }
            }
            DeValue::String(text) => {
                to.insert(key, plain(text.clone().into_owned(), ValueKind::Text));
            }
            DeValue::Integer(_) | DeValue::Float(_) => {
                to.insert(key, plain(slice(), ValueKind::Number));
            }
            DeValue::Boolean(value) => {
                to.insert(key, plain(value.to_string(), ValueKind::Bool));
            }
            DeValue::Datetime(_) => {
                wrong.push(Wrong { at, text: format!("{key}: a time answers no question") });
            }
        }
    }
}

impl Value {
    /// Returns whether a question of this form takes the value.
    pub(super) fn suits(&self, asked: &Asked) -> bool {
        match asked.question.form {
            Form::Number(_) => self.kind == ValueKind::Number || self.text.is_empty(),
            Form::Input | Form::Output => {
                self.kind != ValueKind::List && self.kind != ValueKind::Bool
            }
            Form::Ports => self.kind == ValueKind::List,
            Form::Name | Form::Axes | Form::Gantry | Form::OneOf(_) => self.kind == ValueKind::Text,
        }
    }
}

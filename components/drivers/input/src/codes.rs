//! Names of codes, from the table `codes.txt`.

use crate::event::kind;
use std::{collections::BTreeMap, sync::LazyLock};

/// Lines of type, code and name.
const TABLE: &str = include_str!("codes.txt");

fn rows() -> impl Iterator<Item = (u16, u16, &'static str)> {
    TABLE.lines().filter_map(|line| {
        let mut words = line.split(' ');
        let kind = match words.next()? {
            "key" => kind::KEY,
            "rel" => kind::REL,
            "abs" => kind::ABS,
            "led" => kind::LED,
            _ => return None,
        };
        Some((kind, words.next()?.parse().ok()?, words.next()?))
    })
}

/// Names by type and code.
static NAMES: LazyLock<BTreeMap<(u16, u16), &str>> =
    LazyLock::new(|| rows().map(|(kind, code, name)| ((kind, code), name)).collect());

/// Returns the name of a code as pins have it; a code without one has its number, as in `key-703`.
pub(crate) fn name(kind: u16, code: u16) -> String {
    if let Some(name) = NAMES.get(&(kind, code)) {
        return (*name).to_owned();
    }
    let begin = match kind {
        kind::REL => "rel",
        kind::ABS => "abs",
        kind::LED => "led",
        _ => "key",
    };
    format!("{begin}-{code}")
}

/// Returns the code with a name; codes without a line in the table have none.
pub(crate) fn code(kind: u16, name: &str) -> Option<u16> {
    rows().find(|row| row.0 == kind && row.2 == name).map(|row| row.1)
}

/// Returns all codes of a kind that have a name.
pub(crate) fn all(kind: u16) -> Vec<u16> {
    rows().filter(|row| row.0 == kind).map(|row| row.1).collect()
}

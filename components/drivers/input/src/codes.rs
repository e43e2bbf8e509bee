//! Names of codes, from the table `codes.txt`.

use crate::event::kind;

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

/// Returns the name of a code as pins have it; a code without one is a number.
pub(crate) fn name(kind: u16, code: u16) -> String {
    let row = rows().find(|row| (row.0, row.1) == (kind, code));
    row.map_or_else(|| code.to_string(), |row| row.2.to_owned())
}

/// Returns the code with a name.
pub(crate) fn code(kind: u16, name: &str) -> Option<u16> {
    rows().find(|row| row.0 == kind && row.2 == name).map(|row| row.1)
}

/// Returns all codes of a kind that have a name.
pub(crate) fn all(kind: u16) -> Vec<u16> {
    rows().filter(|row| row.0 == kind).map(|row| row.1).collect()
}

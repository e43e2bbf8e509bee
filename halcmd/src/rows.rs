//! The rows of the table of commands, by what they are for.

use crate::{Error, table::Row};

mod change;
mod checking;
mod drawing;
mod input;
mod load;
mod look;
mod people;
mod time;
mod wire;

/// As many words as one likes.
const ANY: usize = usize::MAX;

/// A row about which there is nothing more to say: what a row leaves out is as here.
const PLAIN: Row = Row {
    name: "",
    usage: "",
    args: (0, 0),
    summary: "",
    help: "",
    words: &[],
    examples: &[],
    related: &[],
    errors: &[],
    parse: |_| Err(Error::Unexpected),
};

/// The groups of commands with their titles, as help lists them.
pub(crate) const GROUPS: &[(&str, &[Row])] = &[
    ("Components and programs", load::ROWS),
    ("Signals, pins and parameters", wire::ROWS),
    ("Threads and time", time::ROWS),
    ("All or nothing", change::ROWS),
    ("Looking", look::ROWS),
    ("What is wrong", checking::ROWS),
    ("The machine as a whole", drawing::ROWS),
    ("For people", people::ROWS),
    ("The input", input::ROWS),
];

/// Every command, as help lists them.
pub(crate) fn rows() -> impl Iterator<Item = &'static Row> {
    GROUPS.iter().flat_map(|(_, rows)| rows.iter())
}

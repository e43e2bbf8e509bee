//! Rows of the table of commands, grouped by purpose.

use crate::language::row::Row;

mod change;
mod checking;
mod drawing;
mod input;
mod load;
mod look;
mod people;
mod time;
mod wire;

/// Groups of commands with their titles, in the order of `help`.
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

/// Returns every command, in the order of `help`.
pub(crate) fn rows() -> impl Iterator<Item = &'static Row> {
    GROUPS.iter().flat_map(|(_, rows)| rows.iter())
}

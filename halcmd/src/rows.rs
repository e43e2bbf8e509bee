//! The rows of the table of commands, by what they are for.

use crate::table::Row;

mod input;
mod load;
mod look;
mod time;
mod wire;

/// As many words as one likes.
const ANY: usize = usize::MAX;

const GROUPS: &[&[Row]] = &[load::ROWS, wire::ROWS, time::ROWS, look::ROWS, input::ROWS];

/// Every command, as help lists them.
pub(crate) fn rows() -> impl Iterator<Item = &'static Row> {
    GROUPS.iter().copied().flatten()
}

//! Looking at a machine as a whole.

use crate::{
    examine,
    rows::{ANY, PLAIN},
    table::Row,
    word::Word as W,
};

pub(super) const ROWS: &[Row] = &[Row {
    name: "order",
    usage: "[--script] [-i INI] [FILE...]",
    args: (0, ANY),
    summary: "print the order of functions that the wiring implies",
    help: "For each thread: its functions, what is read a cycle late, and the order that loses \
           least. Then how long values wait on their way through the machine, and around its \
           feedback loops. With FILE (scripts, or an INI file) it is about that machine, which is \
           neither opened nor run; else about the running one. --script prints the lines that \
           make the better order. Nothing is changed: the order stays yours.",
    words: &[W::Many(&[W::One(&["--script", "-i"]), W::File])],
    examples: &["order", "order machine.ini", "order --script -i machine.ini wiring.hal"],
    related: &["addf", "delf"],
    parse: examine::order,
    ..PLAIN
}];

//! The command that changes a running machine in one transaction.

use crate::{language::parse, language::row::Row, language::word::Word as W};

pub(super) const ROWS: &[Row] = &[Row {
    name: "apply",
    usage: "[--dry-run] [-i INI] FILE|-",
    args: (1, 5),
    summary: "apply all lines of a file at once, or none",
    help: "The lines are checked first, in order, each with what those before it do. Then all \
           stores, values and lists of functions change at one boundary between cycles: no \
           function sees half of it, and no cycle is lost. If any line is refused, nothing is \
           changed. -i takes [SECTION]NAME from this INI file; '-' reads standard input; \
           --dry-run only checks, and opens no devices.",
    words: &[W::Any(&[W::File, W::One(&["--dry-run", "-i", "-"])]), W::Many(&[W::File])],
    examples: &["apply retune.hal", "apply --dry-run -i machine.ini retune.hal"],
    related: &["source", "save", "lock"],
    errors: &[
        ("cannot be part of what is applied", "such a line stands in a script of its own"),
        ("are made while threads run", "make it in parts, or 'stop' before and 'start' after"),
        ("is stuck in its cycle", "nothing changed; find out what that function waits for"),
    ],
    parse: parse::apply,
}];

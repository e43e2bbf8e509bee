//! Commands that check a machine and explain findings.

use crate::{
    Command,
    language::row::Row,
    language::row::{ANY, PLAIN},
    language::word::Word as W,
};

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "check",
        usage: "[--json|--sarif|--parts] [--level LEVEL] [-i INI] [FILE...]",
        args: (0, ANY),
        summary: "say what is wrong with a machine, before it moves",
        help: "FILE is a machine's INI file, or scripts in order; without one it is about the \
               running machine. Nothing is opened and nothing moves. The status of halcmd is that \
               of the worst finding: 0 none or notes, 1 warnings, 2 errors. A comment '# check: \
               allow CODE why', at the end of a line or above it, allows a note or warning there. \
               --parts prints what the machine is made of instead, and what of it is not there.",
        words: &[W::Many(&[W::One(&["--json", "--sarif", "--parts", "--level", "-i"]), W::File])],
        examples: &["check", "check machine.ini", "check --sarif -i machine.ini wiring.hal"],
        related: &["explain", "order"],
        parse: |words| Ok(Command::Check(words.to_vec())),
        ..PLAIN
    },
    Row {
        name: "explain",
        usage: "[CODE...]",
        args: (0, ANY),
        summary: "explain a finding of check",
        help: "What it means, why it matters, what to do, and a script that shows it. Without a \
               code, every code is listed.",
        words: &[W::Many(&[W::Code])],
        examples: &["explain H306"],
        related: &["check"],
        parse: |words| Ok(Command::Explain(words.to_vec())),
        ..PLAIN
    },
];

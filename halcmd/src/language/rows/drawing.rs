//! Commands that examine a machine as a whole.

use crate::{
    language::arguments,
    language::row::Row,
    language::row::{ANY, PLAIN},
    language::word::Word as W,
};

pub(super) const ROWS: &[Row] = &[
    Row {
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
        related: &["addf", "delf", "graph"],
        parse: arguments::order,
        ..PLAIN
    },
    Row {
        name: "graph",
        usage: "[--svg|--dot|--mermaid] [-o FILE] [--all] [--params] [-i INI] [FILE...] [PATTERN...]",
        args: (0, ANY),
        summary: "draw the machine: components, pins, signals, threads",
        help: "A picture (--svg, the default), or a graph for Graphviz or Mermaid, printed or \
               written to the file after -o, whose ending says the format as well. FILE is a \
               script or an INI file: that machine is drawn, neither opened nor run; else the \
               running one. A pattern draws only the signals that it names, or whose pins or \
               components it names, as 'show' would. --all draws pins without a signal as well, \
               --params parameters with their values.",
        words: &[W::Many(&[
            W::One(&["--svg", "--dot", "--mermaid", "--all", "--params", "-o", "-i"]),
            W::File,
            W::Pin,
        ])],
        examples: &[
            "graph -o machine.svg",
            "graph machine.ini -o machine.svg",
            "graph --dot stepgen",
        ],
        related: &["show", "order"],
        parse: arguments::graph,
        ..PLAIN
    },
];

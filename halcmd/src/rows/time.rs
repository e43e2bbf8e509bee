//! Threads, and time.

use crate::{Command, parse, table::Row};
use hal_protocol::Request;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "addf",
        usage: "FUNCT THREAD [POSITION]",
        args: (2, 3),
        summary: "add a function to a thread",
        help: "Position 1 is the first, -1 the last (which is the default).",
        parse: |words| parse::addf(words, false),
    },
    Row {
        name: "initf",
        usage: "FUNCT THREAD [POSITION]",
        args: (2, 3),
        summary: "run a function once in a thread's first cycle",
        help: "That cycle comes after 'start' and before the first ordinary one.",
        parse: |words| parse::addf(words, true),
    },
    Row {
        name: "delf",
        usage: "FUNCT THREAD",
        args: (0, 2),
        summary: "remove a function from a thread",
        help: "The function keeps its state.",
        parse: parse::delf,
    },
    Row {
        name: "start",
        usage: "",
        args: (0, 0),
        summary: "let the threads run their functions",
        help: "",
        parse: |_| Ok(Command::Ask(Request::Start, Some("Realtime threads started".to_owned()))),
    },
    Row {
        name: "stop",
        usage: "",
        args: (0, 0),
        summary: "let the threads run nothing",
        help: "Nothing is reset: 'start' goes on from there.",
        parse: |_| Ok(Command::Ask(Request::Stop, Some("Realtime threads stopped".to_owned()))),
    },
    Row {
        name: "run",
        usage: "TIME",
        args: (1, 1),
        summary: "move the virtual clock",
        help: "Such as 'run 20ms': a number and ns, us, ms or s. Else it stands still.",
        parse: parse::run,
    },
    Row {
        name: "timing",
        usage: "on|off [THREAD]",
        args: (1, 2),
        summary: "switch the times of functions on or off",
        help: "FUNCT.time and FUNCT.tmax, of one thread or all; off at first on the virtual clock.",
        parse: parse::timing,
    },
];

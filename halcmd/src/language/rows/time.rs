//! Commands for threads and time.

use crate::{
    Command, language::parse, language::row::ANY, language::row::Row, language::word::Word as W,
};
use hal_protocol::Request;

const LOCKED: (&str, &str) = ("while HAL is locked", "'unlock' allows changes again");
const NO_FUNCT: (&str, &str) = (
    "not found",
    "'list funct' and 'list thread' name all; load 'threads' or 'motmod' to have threads",
);
const POSITION: (&str, &str) =
    ("bad position", "positions count from 1; negative ones from the end, -1 being the last");

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "addf",
        usage: "FUNCT THREAD [POSITION]",
        args: (2, ANY),
        summary: "add a function to a thread",
        help: "Position 1 is the first, -1 the last (which is the default). Functions run in this \
               order in each cycle, so readers of inputs come first and writers of outputs last.",
        words: &[W::FreeFunct, W::Thread, W::Free],
        examples: &["addf parport.0.read base-thread 1", "addf stepgen.make-pulses base-thread"],
        related: &["delf", "initf", "show", "start"],
        errors: &[
            NO_FUNCT,
            (
                "may only be added to one thread",
                "'delf FUNCT THREAD' takes it out of its present one",
            ),
            POSITION,
            LOCKED,
        ],
        parse: |words| parse::addf(words, false),
    },
    Row {
        name: "initf",
        usage: "FUNCT THREAD [POSITION]",
        args: (2, ANY),
        summary: "run a function once in a thread's first cycle",
        help: "That cycle comes after 'start' and before the first ordinary one.",
        words: &[W::FreeFunct, W::Thread, W::Free],
        examples: &["initf constant.0 servo-thread"],
        related: &["addf", "start"],
        errors: &[NO_FUNCT, ("init cycle already executed", "put the line before 'start'")],
        parse: |words| parse::addf(words, true),
    },
    Row {
        name: "delf",
        usage: "FUNCT THREAD",
        args: (0, 2),
        summary: "remove a function from a thread",
        help: "The function keeps its state.",
        words: &[W::UsedFunct, W::ThreadOfFunct],
        examples: &["delf stepgen.make-pulses base-thread"],
        related: &["addf", "show"],
        errors: &[
            NO_FUNCT,
            ("is not in use", "the function is in no thread"),
            ("doesn't use", "'show thread' says which functions a thread has"),
            LOCKED,
        ],
        parse: parse::delf,
    },
    Row {
        name: "start",
        usage: "",
        args: (0, 0),
        summary: "let the threads run their functions",
        help: "Threads are there from the moment they are loaded, and run nothing until then.",
        words: &[],
        examples: &["start"],
        related: &["stop", "status", "addf"],
        errors: &[
            LOCKED,
            (
                "has failed: threads stay stopped",
                "'status instance' says why; unload the component",
            ),
        ],
        parse: |_| Ok(Command::Send(Request::Start, Some("Realtime threads started".to_owned()))),
    },
    Row {
        name: "stop",
        usage: "",
        args: (0, 0),
        summary: "let the threads run nothing",
        help: "Nothing is reset: 'start' goes on from there.",
        words: &[],
        examples: &["stop"],
        related: &["start", "shutdown"],
        errors: &[LOCKED],
        parse: |_| Ok(Command::Send(Request::Stop, Some("Realtime threads stopped".to_owned()))),
    },
    Row {
        name: "run",
        usage: "TIME",
        args: (1, 1),
        summary: "move the virtual clock",
        help: "Such as 'run 20ms': a number and ns, us, ms or s. Otherwise the virtual \
               clock stands still.",
        words: &[W::Free],
        examples: &["run 20ms", "run 2s"],
        related: &["start", "record"],
        errors: &[
            ("this one is real", "start the instance with 'halrun --virtual'"),
            ("is not a time", "a number and a unit without a blank between them"),
        ],
        parse: parse::run,
    },
    Row {
        name: "timing",
        usage: "on|off [THREAD]",
        args: (1, 2),
        summary: "switch the times of functions on or off",
        help: "FUNCT.time and FUNCT.tmax, of one thread or all; off at first on the virtual clock.",
        words: &[W::One(&["on", "off"]), W::Thread],
        examples: &["timing on servo-thread"],
        related: &["show", "status"],
        errors: &[("is neither on nor off", "the switch comes first, then the thread")],
        parse: parse::timing,
    },
];

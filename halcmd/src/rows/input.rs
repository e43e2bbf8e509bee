//! The input itself.

use crate::{Command, Error, parse, table::Row};
use hal_protocol::Request;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "print",
        usage: "[TEXT]",
        args: (0, 1),
        summary: "print a text with its file and line",
        help: "Quote a text with blanks.",
        parse: |words| Ok(Command::Print(words.first().cloned())),
    },
    Row {
        name: "echo",
        usage: "",
        args: (0, 0),
        summary: "print each line before it is carried out",
        help: "",
        parse: |_| Ok(Command::Echo(true)),
    },
    Row {
        name: "unecho",
        usage: "",
        args: (0, 0),
        summary: "no longer print lines",
        help: "",
        parse: |_| Ok(Command::Echo(false)),
    },
    Row {
        name: "debug",
        usage: "LEVEL",
        args: (1, 1),
        summary: "choose what components' messages are shown",
        help: "0 none, 1 errors, 2 warnings, 3 information, 4 and 5 everything.",
        parse: parse::debug,
    },
    Row {
        name: "source",
        usage: "FILE",
        args: (1, 1),
        summary: "carry out the lines of another file",
        help: "Ends at the first line that fails. Lines are not continued in it.",
        parse: |words| Ok(Command::Source(parse::path(&parse::first(words)))),
    },
    Row {
        name: "help",
        usage: "[COMMAND]",
        args: (0, 1),
        summary: "list the commands, or explain one",
        help: "If you need help to use 'help', then I can't help you.",
        parse: |words| Ok(Command::Help(words.first().cloned())),
    },
    Row {
        name: "quit",
        usage: "",
        args: (0, 0),
        summary: "end the input",
        help: "The rest of the file is not read.",
        parse: |_| Err(Error::UnknownCommand { word: "quit".into(), near: None }),
    },
    Row {
        name: "exit",
        usage: "",
        args: (0, 0),
        summary: "end the input",
        help: "The rest of the file is not read.",
        parse: |_| Err(Error::UnknownCommand { word: "exit".into(), near: None }),
    },
    Row {
        name: "shutdown",
        usage: "",
        args: (0, 0),
        summary: "end the instance",
        help: "Threads stop, outputs go to their safe levels, everything is unloaded.",
        parse: |_| Ok(Command::Ask(Request::Shutdown, None)),
    },
    Row {
        name: "setexact_for_test_suite_only",
        usage: "",
        args: (0, 0),
        summary: "say that periods are exact, which they are",
        help: "Scripts of a test suite use it before they make threads.",
        parse: |_| Ok(Command::SetExact),
    },
];

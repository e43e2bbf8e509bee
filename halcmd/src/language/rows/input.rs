//! Commands about the input itself.

use crate::{
    Command, Error, language::parse, language::row::PLAIN, language::row::Row,
    language::word::Word as W,
};
use hal_protocol::Request;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "print",
        usage: "[TEXT]",
        args: (0, 1),
        summary: "print a text with its file and line",
        help: "Quote a text with blanks.",
        words: &[W::Free],
        examples: &["print \"axes are wired\""],
        related: &["echo"],
        errors: &[("requires at most 1 arguments", "quote the text")],
        parse: |words| Ok(Command::Print(words.first().cloned())),
    },
    Row {
        name: "echo",
        usage: "",
        args: (0, 0),
        summary: "print each line before it is carried out",
        help: "Lines are printed without their comments.",
        related: &["unecho", "print"],
        parse: |_| Ok(Command::Echo(true)),
        ..PLAIN
    },
    Row {
        name: "unecho",
        usage: "",
        args: (0, 0),
        summary: "no longer print lines",
        help: "It ends what 'echo' began.",
        related: &["echo"],
        parse: |_| Ok(Command::Echo(false)),
        ..PLAIN
    },
    Row {
        name: "debug",
        usage: "LEVEL",
        args: (1, 1),
        summary: "choose what components' messages are shown",
        help: "0 none, 1 errors, 2 warnings, 3 information, 4 and 5 everything.",
        words: &[W::One(&["0", "1", "2", "3", "4", "5"])],
        examples: &["debug 3"],
        related: &["status"],
        errors: &[("Debug level must be", "it is a number from 0 to 5")],
        parse: parse::debug,
    },
    Row {
        name: "source",
        usage: "FILE",
        args: (1, 1),
        summary: "carry out the lines of another file",
        help: "Ends at the first line that fails. Lines are not continued in it.",
        words: &[W::File],
        examples: &["source io.hal"],
        related: &["save", "quit"],
        errors: &[(
            "Could not open hal file",
            "names are relative to where the program was started",
        )],
        parse: |words| Ok(Command::Source(parse::path(&parse::first(words)))),
    },
    Row {
        name: "help",
        usage: "[COMMAND]",
        args: (0, 1),
        summary: "list the commands, or explain one",
        help: "If you need help to use 'help', then I can't help you.",
        words: &[W::Topic],
        examples: &["help net"],
        related: &["commands"],
        parse: |words| Ok(Command::Help(words.first().cloned())),
        ..PLAIN
    },
    Row {
        name: "quit",
        usage: "",
        args: (0, 0),
        summary: "end the input",
        help: "The rest of the file is not read.",
        related: &["exit", "shutdown"],
        parse: |_| Err(Error::UnknownCommand { word: "quit".into(), near: None }),
        ..PLAIN
    },
    Row {
        name: "exit",
        usage: "",
        args: (0, 0),
        summary: "end the input",
        help: "The rest of the file is not read.",
        related: &["quit", "shutdown"],
        parse: |_| Err(Error::UnknownCommand { word: "exit".into(), near: None }),
        ..PLAIN
    },
    Row {
        name: "shutdown",
        usage: "",
        args: (0, 0),
        summary: "end the instance",
        help: "Threads stop, outputs go to their safe levels, everything is unloaded.",
        examples: &["shutdown"],
        related: &["stop", "quit"],
        parse: |_| Ok(Command::Send(Request::Shutdown, None)),
        ..PLAIN
    },
    Row {
        name: "setexact_for_test_suite_only",
        usage: "",
        args: (0, 0),
        summary: "say that periods are exact, which they are",
        help: "Scripts of a test suite use it before they make threads.",
        errors: &[("Cannot run 'setexact'", "put the line before the threads are loaded")],
        parse: |_| Ok(Command::SetExact),
        ..PLAIN
    },
];

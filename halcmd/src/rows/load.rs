//! Loading and unloading.

use crate::{Command, command::LockChange, parse, rows::ANY, table::Row};
use hal_protocol::Lock;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "loadrt",
        usage: "MODULE [NAME=VALUE...]",
        args: (1, ANY),
        summary: "load a realtime component",
        help: "Arguments are the component's own, such as count=2, names=a,b or cfg=\"0x378 out\".",
        parse: parse::loadrt,
    },
    Row {
        name: "loadusr",
        usage: "[-w] [-W] [-Wn NAME] [-i] PROGRAM [ARGS...]",
        args: (0, ANY),
        summary: "start a program",
        help: "With -W, wait until its component is ready (-Wn NAME: a component of that name). \
               With -w, wait until it ends, and fail if it fails (-i: never mind). Programs beside \
               this one are found first, then those in PATH.",
        parse: parse::loadusr,
    },
    Row {
        name: "waitusr",
        usage: "NAME",
        args: (1, 1),
        summary: "wait until a program's component is gone",
        help: "Succeeds at once if there is none of this name.",
        parse: |words| Ok(Command::AwaitEnd(parse::first(words))),
    },
    Row {
        name: "unload",
        usage: "NAME|all",
        args: (1, 1),
        summary: "unload a component or end its program",
        help: "Signals stay; the component's pins, parameters and functions go.",
        parse: |words| match parse::first(words).as_str() {
            "all" => Ok(Command::UnloadAll),
            name => Ok(Command::Unload(name.to_owned())),
        },
    },
    Row {
        name: "unloadrt",
        usage: "NAME|all",
        args: (1, 1),
        summary: "unload a realtime component",
        help: "All: the newest first.",
        parse: parse::unloadrt,
    },
    Row {
        name: "unloadusr",
        usage: "NAME|all",
        args: (1, 1),
        summary: "end the program of a component",
        help: "The program receives SIGTERM.",
        parse: parse::unloadusr,
    },
    Row {
        name: "lock",
        usage: "[all|tune|none]",
        args: (0, 1),
        summary: "forbid changes",
        help: "tune: loading, links and functions in threads; all (or no word): also starting and \
               stopping; none: nothing.",
        parse: |words| {
            Ok(Command::Lock(match words.first().map(String::as_str) {
                None | Some("all") => Some(LockChange::To(Lock::ALL)),
                Some("tune") => Some(LockChange::To(Lock::TUNE)),
                Some("none") => Some(LockChange::To(Lock::NONE)),
                Some(_) => None,
            }))
        },
    },
    Row {
        name: "unlock",
        usage: "[all|tune]",
        args: (0, 1),
        summary: "allow changes",
        help: "tune: loading, links and functions in threads; all (or no word): everything.",
        parse: |words| {
            Ok(Command::Lock(match words.first().map(String::as_str) {
                None | Some("all" | "none") => Some(LockChange::To(Lock::NONE)),
                Some("tune") => Some(LockChange::Without(Lock::TUNE)),
                Some(_) => None,
            }))
        },
    },
];

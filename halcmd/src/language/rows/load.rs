//! Commands for loading and unloading.

use crate::{
    Command,
    language::command::LockChange,
    language::parse,
    language::row::Row,
    language::row::{ANY, PLAIN},
    language::word::Word as W,
};
use hal_protocol::Lock;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "loadrt",
        usage: "[--c [--prefix P]] MODULE [NAME=VALUE...]",
        args: (1, ANY),
        summary: "load a realtime component",
        help: "Arguments are the component's own, such as count=2, names=a,b or cfg=\"0x378 out\". A \
               component in C is found where no plugin has its name; with --c, whether or not one \
               has. With --prefix, every name that it makes begins with P.",
        words: &[W::Module, W::Many(&[W::ModuleArg])],
        examples: &["loadrt and2 count=2", "loadrt stepgen step_type=0,0 ctrl_type=p,v"],
        related: &["unloadrt", "loadusr", "addf"],
        errors: &[
            (
                "already exists",
                "a component is loaded once: give all its instances with count= or names= on one line",
            ),
            (
                "no plugin library offers",
                "see which there are: 'loadrt' and TAB; more folders: HAL_RTMOD_DIR",
            ),
            ("Unknown parameter", "the arguments of a component are offered by TAB after its name"),
        ],
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
        words: &[W::Many(&[W::Program])],
        examples: &["loadusr -Wn panel ./panel.py", "loadusr -w halsampler -n 100"],
        related: &["waitusr", "unloadusr", "loadrt"],
        errors: &[
            (
                "exited without becoming ready",
                "the program ended before it made its component: run it by hand to see why",
            ),
            (
                "Waiting for component",
                "the component has another name than the program: give it with -Wn NAME",
            ),
        ],
        parse: parse::loadusr,
    },
    Row {
        name: "waitusr",
        usage: "NAME",
        args: (1, 1),
        summary: "wait until a program's component is gone",
        help: "Succeeds at once if there is none of this name.",
        words: &[W::ProgramComponent],
        examples: &["waitusr halui"],
        related: &["loadusr", "unloadusr"],
        errors: &[(
            "is not a userspace component",
            "it belongs to a plugin, which 'unloadrt' unloads",
        )],
        parse: |words| Ok(Command::AwaitEnd(parse::first(words))),
    },
    Row {
        name: "unload",
        usage: "NAME|all",
        args: (1, 1),
        summary: "unload a component or end its program",
        help: "Signals stay; the component's pins, parameters and functions go.",
        words: &[W::Any(&[W::Component, W::One(&["all"])])],
        examples: &["unload siggen", "unload all"],
        related: &["unloadrt", "unloadusr"],
        errors: &[("is not loaded", "'list comp' names what is")],
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
        words: &[W::Any(&[W::RealtimeComponent, W::One(&["all"])])],
        examples: &["unloadrt siggen", "unloadrt all"],
        related: &["unload", "loadrt"],
        errors: &[
            ("is not loaded", "'list comp' names what is"),
            ("is in use", "unload the component that uses it first"),
        ],
        parse: parse::unloadrt,
    },
    Row {
        name: "unloadusr",
        usage: "NAME|all",
        args: (1, 1),
        summary: "end the program of a component",
        help: "The program receives SIGTERM.",
        words: &[W::Any(&[W::ProgramComponent, W::One(&["all"])])],
        examples: &["unloadusr panel", "unloadusr all"],
        related: &["unload", "waitusr"],
        errors: &[],
        parse: parse::unloadusr,
    },
    Row {
        name: "lock",
        usage: "[all|tune|none]",
        args: (0, 1),
        summary: "forbid changes",
        help: "tune: loading, links and functions in threads; all (or no word): also starting and \
               stopping; none: nothing.",
        words: &[W::One(&["all", "tune", "none"])],
        examples: &["lock tune"],
        related: &["unlock", "status"],
        parse: |words| {
            Ok(Command::Lock(match words.first().map(String::as_str) {
                None | Some("all") => Some(LockChange::To(Lock::ALL)),
                Some("tune") => Some(LockChange::To(Lock::TUNE)),
                Some("none") => Some(LockChange::To(Lock::NONE)),
                Some(_) => None,
            }))
        },
        ..PLAIN
    },
    Row {
        name: "unlock",
        usage: "[all|tune]",
        args: (0, 1),
        summary: "allow changes",
        help: "tune: loading, links and functions in threads; all (or no word): everything.",
        words: &[W::One(&["all", "tune"])],
        examples: &["unlock"],
        related: &["lock", "status"],
        parse: |words| {
            Ok(Command::Lock(match words.first().map(String::as_str) {
                None | Some("all" | "none") => Some(LockChange::To(Lock::NONE)),
                Some("tune") => Some(LockChange::Without(Lock::TUNE)),
                Some(_) => None,
            }))
        },
        ..PLAIN
    },
];

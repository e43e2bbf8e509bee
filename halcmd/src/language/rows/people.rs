//! Commands for people at a terminal.

use crate::{
    Command,
    language::arguments,
    language::parse::{first, unknown_kind},
    language::row::Row,
    language::row::{ANY, PLAIN},
    language::word::Word as W,
    manual::complete::scripts::{self, SHELLS},
};

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "watch",
        usage: "[-n TIME] [--count N] PIN...",
        args: (1, ANY),
        summary: "show values as they change",
        help: "Pins, signals and parameters, or patterns of them as 'show' has them. On a \
               terminal the values are refreshed in place, those that have just changed being \
               marked; elsewhere each change is a line: machine time in seconds, name, value. \
               -n says how often to look (200ms); --count ends it after so many looks.",
        words: &[W::Many(&[W::One(&["-n", "--count"]), W::Variable])],
        examples: &["watch x-pos stepgen.0.position-fb", "watch -n 1s --count 10 pid.0"],
        related: &["meter", "show", "getp", "record"],
        errors: &[("not found", "'list pin', 'list sig' and 'list param' name all")],
        parse: |words| arguments::watch(words).map(Command::Watch),
    },
    Row {
        name: "meter",
        usage: "[NAME]",
        args: (0, 1),
        summary: "show one value, big",
        help: "A pin, signal or parameter; without a name, or with the beginning of several, it \
               is searched for first. Keys: s searches another, left and right go to its \
               neighbours, r resets the minimum and maximum, q ends it.",
        words: &[W::Variable],
        examples: &["meter", "meter spindle-speed"],
        related: &["watch", "getp"],
        errors: &[("needs a terminal", "where there is none, name what to show, or use 'watch'")],
        parse: |words| Ok(Command::Meter(words.first().cloned())),
    },
    Row {
        name: "man",
        usage: "[--roff] COMPONENT [NAME=VALUE...]",
        args: (1, ANY),
        summary: "show the manual page of a component",
        help: "Its pins, parameters, functions and arguments, from what its plugin says, and an \
               example that runs. No machine need be running. What there is depends on how it is \
               loaded: arguments of loadrt may follow. On a terminal the page is shown by MANPAGER, \
               PAGER or less; --roff prints it in the format of man. Of components in C it tells what \
               can be seen of them.",
        words: &[W::Manual, W::Many(&[W::ModuleArg])],
        examples: &["man pid", "man mux_generic config=bb4"],
        related: &["help", "show", "explain"],
        errors: &[("there is no component", "'halcmd man' finds what 'loadrt' finds")],
        parse: |words| Ok(Command::Man(words.to_vec())),
    },
    Row {
        name: "completion",
        usage: "bash|zsh|fish",
        args: (1, 1),
        summary: "print the shell's completion script for the programs",
        help: "For bash, put 'eval \"$(halcmd completion bash)\"' into ~/.bashrc; for zsh, 'source \
           <(halcmd completion zsh)' into ~/.zshrc after compinit; for fish, 'halcmd completion \
           fish | source' into config.fish.",
        words: &[W::One(&["bash", "zsh", "fish"])],
        examples: &["completion bash"],
        related: &["help"],
        parse: |words| {
            let shell = first(words);
            match scripts::script(&shell) {
                Some(text) => Ok(Command::Completion(text)),
                None => Err(unknown_kind("completion", &shell, SHELLS)),
            }
        },
        ..PLAIN
    },
];

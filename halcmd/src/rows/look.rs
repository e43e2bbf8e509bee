//! Looking at what is there.

use crate::{Command, command::ShowKind, parse, rows::ANY, table::Row};
use hal_protocol::Kind;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "show",
        usage: "[all|comp|pin|sig|param|funct|thread|alias] [-t TYPE] [PATTERN...]",
        args: (0, ANY),
        summary: "print things with their values and links",
        help: "A pattern is the beginning of a name, or a glob of the whole. -t selects pins, \
               signals and parameters by type.",
        parse: parse::show,
    },
    Row {
        name: "list",
        usage: "comp|pin|sig|param|funct|thread [PATTERN...]",
        args: (1, ANY),
        summary: "print names",
        help: "Patterns are those of 'show'.",
        parse: parse::list,
    },
    Row {
        name: "save",
        usage: "[KIND] [FILE]",
        args: (0, 2),
        summary: "print the commands that rebuild this state",
        help: "Kinds: all (the default), allu, comp, alias, sig, sigu, link, linka, net, neta, \
               netl, netla, param, thread, unconnectedinpins.",
        parse: parse::save,
    },
    Row {
        name: "status",
        usage: "[all|lock|mem|instance]",
        args: (0, 1),
        summary: "print locks, memory, and how the instance is",
        help: "instance: the clock, scheduling, overruns, and why threads stopped.",
        parse: parse::status,
    },
    Row {
        name: "commands",
        usage: "[PATTERN...]",
        args: (0, ANY),
        summary: "list the commands that components offer",
        help: "With a pattern, also their arguments: COMPONENT.VERB NAME=VALUE..., such as \
               motion.jog joint=0 velocity=10. With --wait, the line ends when it is done.",
        parse: |words| Ok(Command::Show(Some(ShowKind::Of(Kind::Commands)), None, words.to_vec())),
    },
    Row {
        name: "record",
        usage: "FILE [PATTERN...]|off",
        args: (1, ANY),
        summary: "record pins, signals and parameters to a VCD file",
        help: "Without patterns: all of them but functions' times. 'record off' closes the file.",
        parse: parse::record,
    },
];

//! Signals, links and values.

use crate::{Command, parse, rows::ANY, table::Row};
use hal_protocol::Request;

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "net",
        usage: "SIGNAL PIN...",
        args: (1, ANY),
        summary: "join pins by a signal",
        help: "Makes the signal with the type of the first pin if there is none. Arrows between \
               the names (=> <= <=>) are for people and change nothing. Either all pins are \
               linked or none.",
        parse: parse::net,
    },
    Row {
        name: "linkps",
        usage: "PIN SIGNAL",
        args: (2, 2),
        summary: "link a pin to a signal",
        help: "The signal must exist; 'net' also makes it.",
        parse: parse::linkps,
    },
    Row {
        name: "linksp",
        usage: "SIGNAL PIN",
        args: (2, 2),
        summary: "link a signal to a pin",
        help: "As linkps, with its words the other way round.",
        parse: parse::linksp,
    },
    Row {
        name: "unlinkp",
        usage: "PIN",
        args: (1, 1),
        summary: "unlink a pin",
        help: "The pin keeps the signal's last value.",
        parse: parse::unlinkp,
    },
    Row {
        name: "newsig",
        usage: "SIGNAL TYPE",
        args: (2, 2),
        summary: "make a signal",
        help: "Types: bit, float, s32, u32, s64, u64, port.",
        parse: parse::newsig,
    },
    Row {
        name: "delsig",
        usage: "SIGNAL|all",
        args: (1, 1),
        summary: "delete a signal",
        help: "Its pins are unlinked first.",
        parse: parse::delsig,
    },
    Row {
        name: "setp",
        usage: "PIN VALUE",
        args: (2, 2),
        summary: "set a pin or parameter",
        help: "'PIN = VALUE' is the same. A pin that is linked takes its signal's value: see sets.",
        parse: parse::setp,
    },
    Row {
        name: "getp",
        usage: "PIN",
        args: (1, 1),
        summary: "print the value of a pin or parameter",
        help: "A linked pin has its signal's value.",
        parse: |words| Ok(Command::Value(Request::Get { name: parse::first(words) })),
    },
    Row {
        name: "ptype",
        usage: "PIN",
        args: (1, 1),
        summary: "print the type of a pin or parameter",
        help: "One of bit, float, s32, u32, s64, u64, port.",
        parse: |words| Ok(Command::TypeOf(Request::Get { name: parse::first(words) })),
    },
    Row {
        name: "sets",
        usage: "SIGNAL VALUE",
        args: (2, 2),
        summary: "set a signal",
        help: "Only a signal that no pin writes. For a signal of type port, VALUE is the size of \
               its queue in bytes, given once.",
        parse: parse::sets,
    },
    Row {
        name: "gets",
        usage: "SIGNAL",
        args: (1, 1),
        summary: "print the value of a signal",
        help: "Floats are printed with seven digits, integers in decimal.",
        parse: |words| Ok(Command::Value(Request::GetSignal { name: parse::first(words) })),
    },
    Row {
        name: "stype",
        usage: "SIGNAL",
        args: (1, 1),
        summary: "print the type of a signal",
        help: "One of bit, float, s32, u32, s64, u64, port.",
        parse: |words| Ok(Command::TypeOf(Request::GetSignal { name: parse::first(words) })),
    },
    Row {
        name: "alias",
        usage: "pin|param NAME ALIAS",
        args: (3, 3),
        summary: "give a pin or parameter a second name",
        help: "It is listed under the new name; both find it.",
        parse: parse::alias,
    },
    Row {
        name: "unalias",
        usage: "pin|param NAME",
        args: (2, 2),
        summary: "take the second name away",
        help: "",
        parse: parse::unalias,
    },
];

//! Commands that display the state.

use crate::{
    Command, language::command::ShowKind, language::flight, language::parse, language::row::ANY,
    language::row::Row, language::word::Word as W,
};
use hal_protocol::{Kind, Request};

pub(super) const ROWS: &[Row] = &[
    Row {
        name: "show",
        usage: "[all|comp|pin|sig|param|funct|thread|alias|worker|snapshot] [-t TYPE] [PATTERN...]",
        args: (0, ANY),
        summary: "print things with their values and links",
        help: "A pattern is the beginning of a name, or a glob of the whole. -t selects pins, \
               signals and parameters by type.",
        words: &[
            W::One(&[
                "all", "comp", "pin", "sig", "param", "funct", "thread", "alias", "worker",
                "snapshot",
            ]),
            W::Many(&[W::One(&["-t"]), W::NameOfKind]),
        ],
        examples: &["show pin stepgen.0", "show sig *-pos", "show pin -t bit parport"],
        related: &["list", "getp", "watch", "save"],
        errors: &[("Unknown 'show' type", "the kind comes first, then patterns: 'show pin x'")],
        parse: parse::show,
    },
    Row {
        name: "list",
        usage: "comp|pin|sig|param|funct|thread|worker|snapshot [PATTERN...]",
        args: (1, ANY),
        summary: "print names",
        help: "Patterns are those of 'show'.",
        words: &[
            W::One(&["comp", "pin", "sig", "param", "funct", "thread", "worker", "snapshot"]),
            W::Many(&[W::NameOfKind]),
        ],
        examples: &["list pin", "list funct stepgen"],
        related: &["show"],
        errors: &[("Unknown 'list' type", "the kind comes first, then patterns: 'list pin x'")],
        parse: parse::list,
    },
    Row {
        name: "save",
        usage: "[KIND] [FILE]",
        args: (0, 2),
        summary: "print the commands that rebuild this state",
        help: "Kinds: all (the default), allu, comp, alias, sig, sigu, link, linka, net, neta, \
               netl, netla, param, thread, unconnectedinpins.",
        words: &[
            W::One(&[
                "all",
                "allu",
                "comp",
                "alias",
                "sig",
                "sigu",
                "link",
                "linka",
                "net",
                "neta",
                "netl",
                "netla",
                "param",
                "thread",
                "unconnectedinpins",
            ]),
            W::File,
        ],
        examples: &["save", "save all machine.hal"],
        related: &["show", "source"],
        errors: &[
            ("Unknown 'save' type", "a file comes after the kind: 'save all FILE'"),
            ("Can't open 'save' destination", "the folder must be there and writable"),
        ],
        parse: parse::save,
    },
    Row {
        name: "status",
        usage: "[all|lock|mem|instance]",
        args: (0, 1),
        summary: "print locks, memory, and how the instance is",
        help: "instance: the clock, scheduling, overruns, and why threads stopped.",
        words: &[W::One(&["all", "lock", "mem", "instance"])],
        examples: &["status instance"],
        related: &["lock", "show"],
        errors: &[("Unknown 'status' type", "without a word it prints everything")],
        parse: parse::status,
    },
    Row {
        name: "commands",
        usage: "[PATTERN...]",
        args: (0, ANY),
        summary: "list the commands that components offer",
        help: "With a pattern, also their arguments: COMPONENT.VERB NAME=VALUE..., such as \
               motion.jog joint=0 velocity=10. With --wait, the line ends when it is done.",
        words: &[W::Many(&[W::ComponentCommand])],
        examples: &["commands", "commands motion.jog"],
        related: &["help", "show"],
        errors: &[],
        parse: |words| Ok(Command::Show(Some(ShowKind::Of(Kind::Commands)), None, words.to_vec())),
    },
    Row {
        name: "snapshot",
        usage: "NAME",
        args: (1, 1),
        summary: "print the latest record of a snapshot, as JSON",
        help: "A component publishes a snapshot as a whole, such as motion.status in every cycle. \
               Numbers of 64 bits and floats that are not finite are strings. 'show snapshot' \
               lists snapshots with their fields.",
        words: &[W::Snapshot],
        examples: &["snapshot motion.status"],
        related: &["show", "getp", "watch"],
        errors: &[],
        parse: |words| Ok(Command::Value(Request::Snapshot { name: parse::first(words) })),
    },
    Row {
        name: "record",
        usage: "FILE [PATTERN...]|off",
        args: (1, ANY),
        summary: "record pins, signals and parameters to a VCD file",
        help: "Without patterns: all of them but functions' times. 'record off' closes the file. A \
               recording that cannot be written stops with a message, and the machine goes on; \
               'status' shows it. A file of that name stays until the new one has its head.",
        words: &[W::Any(&[W::One(&["off"]), W::File]), W::Many(&[W::Variable])],
        examples: &["record out.vcd stepgen.0", "record off"],
        related: &["run", "watch"],
        errors: &[
            ("already recording", "'record off' ends the present one"),
            ("nothing is being recorded", "'record FILE' starts one"),
        ],
        parse: parse::record,
    },
    Row {
        name: "flight",
        usage: "[on [NAME=VALUE...]|off|save FILE [last]]",
        args: (0, ANY),
        summary: "keep the latest changes of every pin, for when something happens",
        help: "'flight on' keeps them in memory: size=BYTES (64M; 16M if not said), time=TIME \
               before an event and after=TIME after it, file=FILE in which events are kept (with \
               their numbers: FILE-1.vcd), when=CONDITION for what is an event beside faults, \
               following errors and e-stops, as a trigger of halscope says it: x > 5 and not \
               enable. The file's ending says how it is written: .vcd, .fst, .csv or .json. \
               'flight save FILE' writes what there is, \
               'flight save FILE last' the last event; 'flight' says how it is.",
        words: &[
            W::One(&["on", "off", "save"]),
            W::Many(&[W::One(&["size=", "time=", "after=", "file=", "when="]), W::File]),
        ],
        examples: &[
            "flight on time=10s after=1s file=crash.vcd when=spindle.0.speed-out > 24000",
            "flight save now.fst",
        ],
        related: &["record", "status"],
        errors: &[
            ("the flight recorder is off", "'flight on' switches it on"),
            ("trigger: ", "as in x > 5 and not enable; the mark is under what is wrong"),
            ("has seen no event", "'flight save FILE' writes what there is"),
        ],
        parse: flight::parse,
    },
];

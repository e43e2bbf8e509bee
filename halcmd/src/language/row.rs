//! A row of the table of commands, and the names of kinds.

use crate::{
    Command, Error,
    language::command::{SaveKind, StatusKind},
    language::word::Word,
};
use hal_protocol::Kind;

/// Any number of words.
pub(crate) const ANY: usize = usize::MAX;

/// Defaults for the fields that a row omits.
pub(crate) const PLAIN: Row = Row {
    name: "",
    usage: "",
    args: (0, 0),
    summary: "",
    help: "",
    words: &[],
    examples: &[],
    related: &[],
    errors: &[],
    parse: |_| Err(Error::Unexpected),
};

/// A command.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Name of the command.
    pub name: &'static str,
    /// Arguments, as help shows them.
    pub usage: &'static str,
    /// Minimum and maximum number of arguments.
    pub args: (usize, usize),
    /// Description, in a line.
    pub summary: &'static str,
    /// Further description.
    pub help: &'static str,
    /// Possible values of each argument, for completion.
    pub words: &'static [Word],
    /// Example lines.
    pub examples: &'static [&'static str],
    /// Related commands.
    pub related: &'static [&'static str],
    /// Common errors: a part of the message, and the remedy.
    pub errors: &'static [(&'static str, &'static str)],
    /// Parser for words of the right number.
    pub parse: fn(&[String]) -> Result<Command, Error>,
}

/// Kinds of `show` and `list`.
pub const KINDS: &[(&str, Kind)] = &[
    ("comp", Kind::Components),
    ("pin", Kind::Pins),
    ("sig", Kind::Signals),
    ("signal", Kind::Signals),
    ("param", Kind::Params),
    ("parameter", Kind::Params),
    ("funct", Kind::Functs),
    ("function", Kind::Functs),
    ("thread", Kind::Threads),
    ("worker", Kind::Workers),
    ("snapshot", Kind::Snapshots),
];

/// Kinds of `save`.
pub const SAVES: &[(&str, SaveKind)] = &[
    ("all", SaveKind::All),
    ("allu", SaveKind::AllWithPins),
    ("comp", SaveKind::Components),
    ("alias", SaveKind::Aliases),
    ("sig", SaveKind::Signals),
    ("signal", SaveKind::Signals),
    ("sigu", SaveKind::LoneSignals),
    ("link", SaveKind::Links(false)),
    ("linka", SaveKind::Links(true)),
    ("net", SaveKind::Nets(false)),
    ("neta", SaveKind::Nets(true)),
    ("netl", SaveKind::NetLines(false)),
    ("netla", SaveKind::NetLines(true)),
    ("netal", SaveKind::NetLines(true)),
    ("param", SaveKind::Params),
    ("parameter", SaveKind::Params),
    ("thread", SaveKind::Threads),
    ("unconnectedinpins", SaveKind::LonePins),
];

/// Parts of `status`.
pub const STATUSES: &[(&str, StatusKind)] = &[
    ("all", StatusKind::All),
    ("lock", StatusKind::Lock),
    ("mem", StatusKind::Memory),
    ("instance", StatusKind::Instance),
];

impl Row {
    /// Checks the number of arguments.
    pub(super) fn count(&self, given: usize) -> Result<(), Error> {
        let (command, (least, most)) = (self.name, self.args);
        if least == most && given != least {
            Err(Error::Exactly { command, wanted: least, given })
        } else if given < least {
            Err(Error::AtLeast { command, wanted: least, given })
        } else if given > most {
            Err(Error::AtMost { command, wanted: most, given })
        } else {
            Ok(())
        }
    }
}

/// Returns the command with its arguments.
pub(crate) fn line(row: &Row) -> String {
    format!("{} {}", row.name, row.usage).trim_end().to_owned()
}

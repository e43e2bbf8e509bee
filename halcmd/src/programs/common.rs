//! The options that every script has, in halcmd and in halrun.

use crate::{Style, programs::options::Opt};

/// Options of halcmd. The first nine apply to every script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the table of options says what each does")]
pub enum Id {
    Echo,
    KeepGoing,
    Quiet,
    Silent,
    Release,
    Script,
    Verbose,
    VeryVerbose,
    Ini,
    File,
    Help,
    Instance,
    Json,
    Wait,
    Tcl,
    Complete,
}

/// Options that halcmd and halrun have in common.
pub const COMMON: [Opt<Id>; 9] = [
    short(Id::Echo, 'e', "print each line before it is carried out"),
    short(Id::KeepGoing, 'k', "keep going after a line that fails"),
    short(Id::Quiet, 'q', "print errors only (the default)"),
    short(Id::Silent, 'Q', "print no listings, and nothing but what failed"),
    short(Id::Release, 'R', "release locks of a crashed client (there are none)"),
    short(Id::Script, 's', "print for programs: no headers, no padding"),
    short(Id::Verbose, 'v', "say what each command did"),
    short(Id::VeryVerbose, 'V', "also show every message of components"),
    Opt { value: Some("FILE"), ..short(Id::Ini, 'i', "take [SECTION]NAME from this INI file") },
];

/// Applies an option to the style of a session.
pub fn apply(style: &mut Style, id: Id) {
    match id {
        Id::Echo => style.echo = true,
        Id::KeepGoing => style.keep_going = true,
        Id::Silent => style.silent = true,
        Id::Script => style.script = true,
        Id::Verbose | Id::VeryVerbose => style.verbose = true,
        Id::Json => style.json = true,
        Id::Wait => style.wait = true,
        Id::Quiet
        | Id::Release
        | Id::Ini
        | Id::File
        | Id::Help
        | Id::Instance
        | Id::Tcl
        | Id::Complete => {}
    }
}

pub(crate) const fn short(id: Id, letter: char, help: &'static str) -> Opt<Id> {
    Opt { id, short: Some(letter), long: None, value: None, variable: None, help }
}

//! Errors of lines, files and options, in the user's words.

use hal_output::Unwritten;
use hal_protocol::Failure;

/// Error of a line, a file or an option. The messages are LinuxCNC's where it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the sentence of each variant is its documentation")]
pub enum Error {
    /// The engine refused the request.
    Engine(Failure),
    /// The error has been reported already, with its own place.
    AlreadyReported,
    /// The output of a command could not be written.
    Output(Unwritten),
    UnterminatedQuote,
    TooManyTokens,
    CarriageReturn,
    LineTooLong,
    EmptyVariable,
    MissingParenthesis,
    MissingBracket,
    VariableTooLong,
    NoEnvironment {
        name: Box<str>,
    },
    NoIniVariable {
        section: Box<str>,
        name: Box<str>,
        hint: Box<str>,
    },
    UnknownCommand {
        word: Box<str>,
        near: Option<Box<str>>,
    },
    Exactly {
        command: &'static str,
        wanted: usize,
        given: usize,
    },
    AtLeast {
        command: &'static str,
        wanted: usize,
        given: usize,
    },
    AtMost {
        command: &'static str,
        wanted: usize,
        given: usize,
    },
    SignalType {
        word: Box<str>,
    },
    FilterType {
        word: Box<str>,
    },
    NoPin,
    AliasKind {
        command: &'static str,
        word: Box<str>,
    },
    NotApplied {
        word: Box<str>,
        why: Box<str>,
    },
    NoFunct,
    NoThread,
    Level,
    Switch {
        word: Box<str>,
    },
    Kind {
        command: &'static str,
        word: Box<str>,
        kinds: Box<str>,
    },
    NoHelp {
        word: Box<str>,
        near: Option<Box<str>>,
    },
    Time {
        word: Box<str>,
    },
    BadOption {
        command: &'static str,
        option: char,
    },
    NeedsArgument {
        command: &'static str,
        option: char,
    },
    LongOption {
        program: &'static str,
        option: Box<str>,
        near: Option<Box<str>>,
    },
    LongNeedsArgument {
        program: &'static str,
        option: Box<str>,
    },
    LongTakesNone {
        program: &'static str,
        option: Box<str>,
    },
    OptionValue {
        program: &'static str,
        option: Box<str>,
        value: Box<str>,
        why: Box<str>,
    },
    NoProgram,
    Locked,
    NotStarted {
        program: Box<str>,
        why: Box<str>,
    },
    ProgramFailed {
        program: Box<str>,
        status: i32,
    },
    ProgramKilled {
        program: Box<str>,
    },
    NotReady {
        program: Box<str>,
        component: Box<str>,
        failed: bool,
    },
    NotLoaded {
        name: Box<str>,
        near: Option<Box<str>>,
    },
    NotAProgram {
        name: Box<str>,
    },
    NoFile {
        path: Box<str>,
        why: Box<str>,
    },
    NoCommandFile {
        path: Box<str>,
        why: Box<str>,
    },
    TooManySourced {
        path: Box<str>,
    },
    TooDeep {
        path: Box<str>,
    },
    NoDestination {
        path: Box<str>,
        why: Box<str>,
    },
    NotWritten {
        path: Box<str>,
        why: Box<str>,
    },
    GivenUp {
        command: Box<str>,
        why: Box<str>,
    },
    /// The INI file was refused.
    Ini(hal_ini::Error),
    /// `place` is the profile, or a line of it.
    Profile {
        place: Box<str>,
        why: Box<str>,
    },
    IniNotFound {
        file: Box<str>,
        folders: Box<str>,
    },
    NotYet {
        what: Box<str>,
        instead: &'static str,
    },
    TooManyFiles {
        files: Box<str>,
    },
    Extension {
        file: Box<str>,
    },
    NoCode {
        word: Box<str>,
        near: Option<Box<str>>,
    },
    NoManual {
        word: Box<str>,
        near: Option<Box<str>>,
    },
    /// An error that a Tcl script did not catch.
    Tcl {
        text: Box<str>,
    },
    TclEnded {
        status: Option<i32>,
    },
    NoTclsh,
    NoTclPackage {
        folder: Box<str>,
    },
    /// Arguments of two `loadrt` lines that `TWOPASS` cannot join.
    LoadsDiffer {
        module: Box<str>,
        given: Box<str>,
        first: Box<str>,
        at: Box<str>,
    },
    /// A stand-in on the real clock that motion depends on.
    StandinUsed {
        stand_in: Box<str>,
        pin: Box<str>,
    },
    ThreadsExist,
    NoTask,
    NoScreen,
    Unexpected,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Engine(failure) => f.write_str(&failure.text),
            Self::AlreadyReported => Ok(()),
            Self::Output(unwritten) => unwritten.fmt(f),
            Self::UnterminatedQuote => f.write_str("unterminated quoted string"),
            Self::TooManyTokens => f.write_str("too many tokens on line"),
            Self::CarriageReturn => f.write_str("File contains embedded carriage returns."),
            Self::LineTooLong => f.write_str("Line too long."),
            Self::EmptyVariable => f.write_str("Empty variable name."),
            Self::MissingParenthesis => f.write_str("Missing close parenthesis."),
            Self::MissingBracket => f.write_str("Missing close square bracket."),
            Self::VariableTooLong => f.write_str("Variable name too long."),
            Self::NoEnvironment { name } => write!(f, "Environment variable '{name}' not found."),
            Self::NoIniVariable { section, name, .. } => {
                write!(f, "Ini variable '[{section}]{name}' not found.")
            }
            Self::UnknownCommand { word, .. } => write!(f, "Unknown command '{word}'"),
            Self::Exactly { command, wanted, given } => {
                write!(f, "{command} requires {wanted} arguments, {given} given")
            }
            Self::AtLeast { command, wanted, given } => {
                write!(f, "{command} requires at least {wanted} arguments, {given} given")
            }
            Self::AtMost { command, wanted, given } => {
                write!(f, "{command} requires at most {wanted} arguments, {given} given")
            }
            Self::SignalType { word } => write!(f, "Unknown signal type '{word}'"),
            Self::FilterType { word } => write!(f, "Unknown type '{word}'"),
            Self::NoPin => f.write_str("'net' requires at least one pin, none given"),
            Self::AliasKind { command, .. } => write!(f, "{command} failed"),
            Self::NotApplied { word, .. } => {
                write!(f, "'{word}' cannot be part of what is applied")
            }
            Self::NoFunct => f.write_str("missing function name"),
            Self::NoThread => f.write_str("missing thread name"),
            Self::Level => f.write_str("Debug level must be >=0 and <= 5"),
            Self::Switch { word } => write!(f, "'{word}' is neither on nor off"),
            Self::Kind { command, word, .. } => write!(f, "Unknown '{command}' type '{word}'"),
            Self::NoHelp { word, .. } => write!(f, "No help for unknown command '{word}'"),
            Self::Time { word } => write!(f, "'{word}' is not a time"),
            Self::BadOption { command, option } => {
                write!(f, "{command}: invalid option -- '{option}'")
            }
            Self::NeedsArgument { command, option } => {
                write!(f, "{command}: option requires an argument -- '{option}'")
            }
            Self::LongOption { program, option, near } => {
                write!(f, "{program}: unrecognized option '--{option}'")?;
                match near {
                    Some(near) => write!(f, "; did you mean --{near}?"),
                    None => Ok(()),
                }
            }
            Self::LongNeedsArgument { program, option } => {
                write!(f, "{program}: option '--{option}' requires an argument")
            }
            Self::LongTakesNone { program, option } => {
                write!(f, "{program}: option '--{option}' doesn't allow an argument")
            }
            Self::OptionValue { program, option, value, why } => {
                write!(f, "{program}: {option} '{value}': {why}")
            }
            Self::NoProgram => f.write_str("execv(): No such file or directory"),
            Self::Locked => f.write_str("HAL is locked, loading of programs is not permitted"),
            Self::NotStarted { program, why } => write!(f, "execv({program}): {why}"),
            Self::ProgramFailed { program, status } => {
                write!(f, "program '{program}' failed, returned {status}")
            }
            Self::ProgramKilled { program } => {
                write!(f, "program '{program}' did not exit normally")
            }
            Self::NotReady { program, .. } => {
                write!(f, "{program} exited without becoming ready")
            }
            Self::NotLoaded { name, .. } => write!(f, "component '{name}' is not loaded"),
            Self::NotAProgram { name } => write!(f, "'{name}' is not a userspace component"),
            Self::NoFile { path, why } => write!(f, "Could not open hal file '{path}': {why}"),
            Self::NoCommandFile { path, .. } => write!(f, "Could not open command file '{path}'"),
            Self::TooManySourced { path } => {
                write!(f, "'{path}': more than 10000 files are sourced, one from the other")
            }
            Self::TooDeep { path } => {
                write!(f, "'{path}' is sourced within itself, or files are nested too deeply")
            }
            Self::NoDestination { path, .. } => {
                write!(f, "Can't open 'save' destination '{path}'")
            }
            Self::NotWritten { path, why } => write!(f, "cannot write '{path}': {why}"),
            Self::GivenUp { command, why } => write!(f, "{command}: {why}"),
            Self::Ini(error) => error.fmt(f),
            Self::Profile { place, why } => write!(f, "{place}: {why}"),
            Self::IniNotFound { file, .. } => write!(f, "cannot find '{file}'"),
            Self::NotYet { what, .. } => write!(f, "{what} is not supported"),
            Self::TooManyFiles { files } => write!(f, "halrun: too many arguments <{files}>"),
            Self::Extension { file } => {
                write!(f, "halrun: Unknown file extension for filename=<{file}>")
            }
            Self::NoCode { word, .. } => write!(f, "there is no code '{word}'"),
            Self::NoManual { word, .. } => write!(f, "there is no component '{word}'"),
            Self::Tcl { text } => f.write_str(text),
            Self::TclEnded { status: Some(status) } => {
                write!(f, "the file ended itself with status {status}")
            }
            Self::TclEnded { status: None } => f.write_str("a signal ended tclsh"),
            Self::NoTclsh => f.write_str("Tcl files need tclsh, which is not installed"),
            Self::NoTclPackage { folder } => {
                write!(f, "Ferrule's package for Tcl is not in '{folder}'")
            }
            Self::LoadsDiffer { module, given, first, at } => {
                write!(f, "loadrt {module}: '{given}' cannot be joined with '{first}' of {at}")
            }
            Self::StandinUsed { stand_in, pin } => {
                write!(
                    f,
                    "'{pin}' depends on the stand-in '{stand_in}', which stays 0 on the real clock"
                )
            }
            Self::ThreadsExist => {
                f.write_str("HAL_LIB: Cannot run 'setexact' after a thread has been created")
            }
            Self::NoTask => f.write_str("this machine has no task, which runs programs"),
            Self::NoScreen => f.write_str("this view needs a terminal"),
            Self::Unexpected => f.write_str("the engine's answer does not match the request"),
        }
    }
}

impl std::error::Error for Error {}

impl Error {
    /// Returns the messages that precede the error, one sentence each.
    #[must_use]
    pub fn before(&self) -> Vec<String> {
        match self {
            Self::NotReady { program, component, failed: true } => {
                vec![format!("waitpid failed {program} {component}")]
            }
            _ => Vec::new(),
        }
    }
}

impl From<hal_ini::Error> for Error {
    fn from(error: hal_ini::Error) -> Self {
        Self::Ini(error)
    }
}

impl From<Unwritten> for Error {
    fn from(unwritten: Unwritten) -> Self {
        Self::Output(unwritten)
    }
}

impl From<Failure> for Error {
    fn from(failure: Failure) -> Self {
        Self::Engine(failure)
    }
}

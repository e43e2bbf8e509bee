//! Failures of the commands, in the user's words.

use std::path::PathBuf;

/// Reason why a command has not done its work.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A program of Ferrule is not beside this one.
    NoProgram { name: &'static str },
    /// A program could not be started.
    NotStarted { name: &'static str, why: Box<str> },
    /// A program has ended with this status before it did its work.
    Ended { name: &'static str, status: Box<str> },
    /// A file or folder could not be read or written.
    File { path: PathBuf, why: Box<str> },
    /// There is no such machine.
    NoMachine { path: PathBuf },
    /// The INI file is wrong.
    Ini(hal_ini::Error),
    /// The name of the instance is wrong.
    Instance(Box<str>),
    /// An instance of this name runs.
    Runs { name: Box<str> },
    /// The interface that the INI file names is the panel, whose options stand there.
    PanelOfIni { option: &'static str },
    /// The recording of the demonstration lacks a line.
    NotRecorded { line: Box<str> },
    /// The folder of the demonstration holds another file of this name.
    Other { path: PathBuf },
    /// None of the machine's files has this name.
    NoKept { name: PathBuf, known: Box<str> },
    /// A file has no state of this number.
    NoState { file: Box<str>, number: u32, numbers: Box<[u32]> },
    /// The machine runs, and writes its files itself.
    Writes { name: Box<str> },
    /// A question needs a person at a terminal.
    NoTerminal { what: &'static str, instead: &'static str },
    /// No section of the manual has the words.
    NotInManual { words: Box<str> },
    /// The machine cannot be commissioned.
    Unsuited { path: PathBuf, why: Box<str> },
    /// The instance has ended, or does not answer.
    Lost(Box<str>),
    /// The file of results cannot be read.
    Results { path: PathBuf, line: usize },
    /// Standard output does not take the text.
    Output(hal_output::Unwritten),
    /// Signals cannot be taken.
    Signals(Box<str>),
}

impl Failure {
    pub(crate) fn file(path: impl Into<PathBuf>, why: &std::io::Error) -> Self {
        Self::File { path: path.into(), why: hal_output::reason(why).into() }
    }
}

impl core::fmt::Display for Failure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoProgram { name } => {
                write!(f, "{name} is not beside this program")
            }
            Self::NotStarted { name, why } => write!(f, "{name}: {why}"),
            Self::Ended { name, status } => write!(f, "{name} has ended ({status})"),
            Self::File { path, why } | Self::Unsuited { path, why } => {
                write!(f, "{}: {why}", path.display())
            }
            Self::NoMachine { path } => write!(
                f,
                "{}: there is no such file; 'ferrule new' writes a machine, 'ferrule demo' shows one",
                path.display()
            ),
            Self::Ini(error) => write!(f, "{error}"),
            Self::Instance(why) => f.write_str(why),
            Self::Runs { name } => write!(
                f,
                "instance '{name}' runs already: 'ferrule stop' ends it, '--instance NAME' starts another beside it"
            ),
            Self::PanelOfIni { option } => write!(
                f,
                "{option}: the INI file starts the panel itself ([DISPLAY]DISPLAY = halpanel); write it behind halpanel there"
            ),
            Self::NotRecorded { line } => write!(f, "the recording has no '{line}'"),
            Self::Other { path } => write!(
                f,
                "{}: is there already, and is not the demonstration's: choose another --folder",
                path.display()
            ),
            Self::NoKept { name, known } => write!(
                f,
                "{}: is none of the machine's files with states, which are: {}",
                name.display(),
                known
            ),
            Self::NoState { file, number, numbers } if numbers.is_empty() => {
                write!(f, "{file}: has no state {number}: it has none")
            }
            Self::NoState { file, number, numbers } => {
                let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
                write!(f, "{file}: has no state {number}: it has {}", numbers.join(", "))
            }
            Self::Writes { name } => write!(
                f,
                "instance '{name}' runs and writes its files itself: 'ferrule stop' ends it, then restore"
            ),
            Self::NoTerminal { what, instead } => {
                write!(f, "{what} asks a person at a terminal: {instead}")
            }
            Self::NotInManual { words } => write!(
                f,
                "no section of the manual has '{words}': fewer words find more, 'ferrule docs' lists the chapters"
            ),
            Self::Lost(why) => write!(f, "the machine does not answer: {why}"),
            Self::Results { path, line } => {
                write!(f, "{}:{line}: not a line of results; --again begins anew", path.display())
            }
            Self::Output(unwritten) => write!(f, "{unwritten}"),
            Self::Signals(why) => write!(f, "signals: {why}"),
        }
    }
}

impl core::error::Error for Failure {}

impl From<hal_output::Unwritten> for Failure {
    fn from(unwritten: hal_output::Unwritten) -> Self {
        Self::Output(unwritten)
    }
}

impl From<hal_ini::Error> for Failure {
    fn from(error: hal_ini::Error) -> Self {
        Self::Ini(error)
    }
}

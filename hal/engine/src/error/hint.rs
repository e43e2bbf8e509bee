//! Companions of an error: its errno, its finding, and a suggested correction.

use crate::Error;
use hal_protocol::{Code, Failure, Kind, NOT_FROM_AFAR};

impl Error {
    /// Returns the errno of the error.
    #[must_use]
    pub const fn errno(&self) -> i32 {
        match self {
            Self::NotFound { .. }
            | Self::NoItem { .. }
            | Self::NoPin { .. }
            | Self::NoModule { .. }
            | Self::NotLoaded { .. }
            | Self::NoTicket { .. }
            | Self::NoService { .. }
            | Self::NoSignals => -2,
            Self::Locked { .. } => -1,
            Self::NotWritable { .. } => -13,
            Self::OutOfMemory | Self::TooManyComponents { .. } => -12,
            Self::InUseBy { .. }
            | Self::Stuck { .. }
            | Self::ThreadsLate
            | Self::WorkerStuck { .. }
            | Self::StreamTaken { .. } => -16,
            Self::Duplicate { .. } | Self::ModuleExists { .. } | Self::ServiceTaken { .. } => -17,
            Self::OutOfRange { .. } => -34,
            Self::Guarded { .. } | Self::NotFromAfar => NOT_FROM_AFAR,
            Self::QueueAllocated { .. } => -106,
            Self::InitFailed { code, .. } | Self::CommandFailed { code, .. } => *code,
            Self::Watch(e) => e.errno(),
            Self::Loading(e) => e.error.errno(),
            _ => -22,
        }
    }

    /// Converts the error to the wording of the commands that set and get values.
    pub(crate) fn of_value(self) -> Self {
        match self {
            Self::NotFound { what, name, near } => Self::NoItem { what, name, near },
            other => other,
        }
    }

    /// Returns the word of the request that is wrong, if it is one word.
    #[must_use]
    pub fn word(&self) -> Option<&str> {
        match self {
            Self::NameTooLong { name, .. }
            | Self::BadName { name, .. }
            | Self::Duplicate { name, .. }
            | Self::NotFound { name, .. }
            | Self::NoItem { name, .. }
            | Self::NoPin { name, .. }
            | Self::SignalIsPin { name }
            | Self::Guarded { name, .. }
            | Self::NotWritable { name, .. }
            | Self::QueueAllocated { name }
            | Self::ModuleExists { name, .. }
            | Self::NoModule { name, .. }
            | Self::TooManyItems { name, .. }
            | Self::TooManyComponents { name, .. }
            | Self::InitFailed { name, .. }
            | Self::OpenFailed { name, .. }
            | Self::NotLoaded { name }
            | Self::NotRealtime { name }
            | Self::NotAProgram { name }
            | Self::InUseBy { name, .. } => Some(name),
            Self::LinkedElsewhere { pin, .. }
            | Self::AlreadyLinked { pin, .. }
            | Self::TypeMismatch { pin, .. }
            | Self::CannotAdd { pin, .. }
            | Self::SecondWriter { pin, .. } => Some(pin),
            Self::HasWriter { signal, .. }
            | Self::PortIo { signal }
            | Self::PortReaders { signal } => Some(signal),
            Self::OneThreadOnly { funct }
            | Self::NeedsFp(funct, _)
            | Self::NotInUse { funct }
            | Self::NotInThread { funct, .. }
            | Self::InitDone { funct, .. } => Some(funct),
            Self::Watch(e) => e.word(),
            Self::Loading(e) => e.word.as_deref().or_else(|| e.error.word()),
            Self::UnknownParameter { word, .. }
            | Self::InvalidParameter { word }
            | Self::InvalidArgument { word, .. }
            | Self::ArgumentRange { word, .. } => Some(word),
            _ => None,
        }
    }

    /// Returns the code under which `explain` describes the error.
    #[must_use]
    pub const fn finding(&self) -> Option<Code> {
        Some(match self {
            Self::NameTooLong { .. } | Self::BadName { .. } => Code::BadName,
            Self::Duplicate { .. } | Self::ModuleExists { .. } => Code::NameTaken,
            Self::NotFound { .. } | Self::NoItem { .. } | Self::NoPin { .. } => Code::NoSuchName,
            Self::LinkedElsewhere { .. } | Self::AlreadyLinked { .. } => Code::LinkedTwice,
            Self::TypeMismatch { .. } | Self::CannotAdd { .. } => Code::TypeMismatch,
            Self::HasWriter { .. } | Self::SecondWriter { .. } => Code::TwoWriters,
            Self::PortIo { .. } | Self::PortReaders { .. } | Self::QueueAllocated { .. } => {
                Code::PortMisused
            }
            Self::SignalIsPin { .. } => Code::NamedAsPin,
            Self::NotWritable { .. } => Code::NotWritable,
            Self::InvalidValue { .. } | Self::OutOfRange { .. } => Code::BadValue,
            Self::BadPosition(_) | Self::PositionTooFar { .. } => Code::BadPosition,
            Self::OneThreadOnly { .. } => Code::AddedTwice,
            Self::NeedsFp(..) => Code::NeedsFp,
            Self::PeriodTooShort { .. } | Self::BadPeriod { .. } => Code::BadPeriod,
            Self::NoModule { .. } | Self::Plugin(_) => Code::NoComponent,
            Self::UnknownParameter { .. }
            | Self::InvalidParameter { .. }
            | Self::InvalidArgument { .. }
            | Self::ArgumentRange { .. }
            | Self::TooManyItems { .. }
            | Self::MissingArgument { .. }
            | Self::CountAndNames => Code::BadArgument,
            Self::InitFailed { .. }
            | Self::OpenFailed { .. }
            | Self::ServiceTaken { .. }
            | Self::TooManyComponents { .. } => Code::LoadRefused,
            Self::NoService { .. } => Code::NoService,
            Self::Loading(e) => return e.error.finding(),
            _ => return None,
        })
    }

    /// Returns the kind of things among which a name was not found, or of which there are too many.
    fn kind(&self) -> Option<Kind> {
        match self {
            Self::NotFound { what: "thread", .. } => Some(Kind::Threads),
            Self::NotFound { what: "signal", .. } => Some(Kind::Signals),
            Self::NotFound { what: "function", .. } => Some(Kind::Functs),
            Self::TooManyComponents { .. } => Some(Kind::Components),
            Self::Loading(e) => e.error.kind(),
            _ => None,
        }
    }

    /// Returns a suggested correction.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NotFound { near, .. }
            | Self::NoItem { near, .. }
            | Self::NoPin { near, .. }
            | Self::NoModule { near, .. } => near.as_ref().map(|n| format!("did you mean {n}?")),
            Self::ModuleExists { name, again: true } => {
                Some(format!("for more instances, give them names: loadrt {name} names=a,b"))
            }
            Self::ModuleExists { .. } => {
                Some("it is loaded once: give all it shall make on one loadrt line".to_owned())
            }
            Self::TooManyComponents { .. } => {
                Some("one loadrt line with names= or count= makes many instances".to_owned())
            }
            Self::UnknownParameter { near: Some(near), .. } => {
                Some(format!("did you mean {near}?"))
            }
            Self::UnknownParameter { takes, .. } if takes.is_empty() => {
                Some("it takes no arguments".to_owned())
            }
            Self::UnknownParameter { takes, .. } => Some(format!("it takes {takes}")),
            Self::InvalidValue { expects, .. } | Self::OutOfRange { expects, .. } => {
                Some((*expects).to_owned())
            }
            Self::InvalidArgument { expects, doc, .. } if doc.is_empty() => {
                Some((*expects).to_owned())
            }
            Self::InvalidArgument { expects, doc, word, .. } => Some(expected(expects, word, doc)),
            Self::ArgumentRange { expects, doc, word, .. } => Some(expected(expects, word, doc)),
            Self::Loading(e) => e.hint(),
            Self::Plugin(e) => e.hint(),
            Self::NotWritable { name, why, .. } => {
                Some(why.replace("'unlinkp'", &["'unlinkp ", name, "'"].concat()))
            }
            Self::InvalidParameter { .. } => {
                Some("an argument is NAME=VALUE, such as count=2".to_owned())
            }
            Self::BadPosition(_) => Some("1 is the first, -1 the last".to_owned()),
            Self::PositionTooFar { position, most } => {
                let sign = if *position > 0 { "" } else { "-" };
                Some(format!("it may be {sign}1 to {sign}{most}"))
            }
            Self::NameTooLong { .. } => Some(format!("at most {} characters", hal_abi::NAME_LEN)),
            Self::TypeMismatch { pin, pin_type, signal, signal_type } => Some(format!(
                "pin '{pin}' is {}, signal '{signal}' is {}",
                pin_type.name(),
                signal_type.name()
            )),
            Self::MissingArgument { name, doc } => {
                Some(format!("{name}=: {}", doc.trim_end_matches('.')))
            }
            Self::NeedsFp(funct, thread) => Some(format!(
                "create '{thread}' with floating point (fp1=1, base_thread_fp=1), or add {funct} to another \
                 thread"
            )),
            Self::BadPeriod { .. } => Some("expected 1000 to 1000000000000 ns".to_owned()),
            Self::PeriodTooShort { .. } => Some("create the fastest thread first".to_owned()),
            Self::Faulted { .. } | Self::WorkerFailed { .. } => {
                Some("'status' says why; unload it to go on".to_owned())
            }
            Self::InUseBy { user, .. } => Some(format!("unload '{user}' first")),
            Self::LinkedElsewhere { pin, .. } | Self::AlreadyLinked { pin, .. } => {
                Some(format!("'unlinkp {pin}' frees it"))
            }
            Self::TooManyStores { .. } => {
                Some("do it in parts, or 'stop' before and 'start' after".to_owned())
            }
            Self::SecondWriter { pin, other, .. } => Some(format!(
                "a signal has one writer: 'unlinkp {other}' before this line lets {pin} be it"
            )),
            Self::CountAndNames => {
                Some("leave out count=: names= makes as many as it names".to_owned())
            }
            Self::NotStarted => Some("'start' lets the threads run".to_owned()),
            Self::NoService { name, .. } => Some(format!("load {name} first, such as trivkins")),
            _ => None,
        }
    }
}

impl std::error::Error for Error {}

/// Returns the hint about the value of an argument: what is expected, and the argument's description.
fn expected(expects: &str, word: &str, doc: &str) -> String {
    let name = word.split_once('=').map_or(word, |(name, _)| name);
    format!("{expects}; {name}=: {doc}")
}

/// Returns the message for a locked action, as in LinuxCNC: two forms for calls, one for programs.
pub(crate) fn locked(what: &str) -> String {
    match what {
        "loading of programs" => format!("HAL is locked, {what} is not permitted"),
        "link" | "unlink" | "signal_delete" | "pin_alias" | "param_alias" => {
            format!("{what} called while HAL locked")
        }
        _ => format!("{what} called while HAL is locked"),
    }
}

impl From<crate::PluginError> for Error {
    fn from(e: crate::PluginError) -> Self {
        Self::Plugin(e)
    }
}

impl From<Error> for Failure {
    fn from(e: Error) -> Self {
        Self {
            code: e.errno(),
            text: e.to_string(),
            hint: e.hint(),
            word: e.word().map(str::to_owned),
            finding: e.finding(),
            kind: e.kind(),
        }
    }
}

//! Messages that follow the error of a failed command, as in LinuxCNC.

use crate::{Command, Error};
use hal_protocol::Request;

/// Messages at the end of a failed command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Trailer {
    /// No message.
    Nothing,
    /// `newsig failed` and the like.
    Plain(&'static str),
    /// `insmod for MODULE failed, returned -1`.
    Load(String),
    /// `rmmod failed, returned -1`, and a line with the name of the module.
    Unload(String),
    /// `net`: depends on the error.
    Net(String),
}

impl Trailer {
    pub(crate) fn of(command: &Command) -> Self {
        let Command::Send(request, _) = command else { return Self::Nothing };
        match request {
            Request::Load { module, .. } | Request::LoadForeign { module, .. } => {
                Self::Load(module.clone())
            }
            Request::Unload { name } => Self::Unload(name.clone()),
            Request::Net { signal, .. } => Self::Net(signal.clone()),
            Request::NewSignal { .. } => Self::Plain("newsig failed"),
            Request::Link { .. } => Self::Plain("link failed"),
            Request::Unlink { .. } => Self::Plain("unlink failed"),
            Request::Alias { .. } => Self::Plain("alias failed"),
            Request::Unalias { .. } => Self::Plain("unalias failed"),
            Request::AddFunct { init: true, .. } => Self::Plain("initf failed"),
            Request::AddFunct { .. } => Self::Plain("addf failed"),
            Request::RemoveFunct { .. } => Self::Plain("delf failed"),
            _ => Self::Nothing,
        }
    }

    pub(crate) fn lines(&self, error: &Error) -> Vec<String> {
        let Error::Engine(failure) = error else { return Vec::new() };
        match self {
            Self::Nothing => Vec::new(),
            Self::Plain(text) => vec![(*text).to_owned()],
            Self::Load(module) => vec![format!("insmod for {module} failed, returned -1")],
            Self::Unload(_)
                if failure.text.ends_with("is not loaded")
                    || failure.text.ends_with("is not a realtime module") =>
            {
                Vec::new()
            }
            Self::Unload(name) => {
                vec!["rmmod failed, returned -1".to_owned(), format!("unloadrt failed on '{name}'")]
            }
            // Errors of the first checks begin with a capital or a quote, and need no further
            // message.
            Self::Net(_) if !failure.text.starts_with(|c: char| c.is_ascii_lowercase()) => {
                Vec::new()
            }
            Self::Net(signal) if failure.text.starts_with("signal_new") => {
                vec![format!("Failed to create signal '{signal}'")]
            }
            Self::Net(signal) if failure.text.starts_with("signal name") => {
                vec![format!("Failed to create signal '{signal}'")]
            }
            Self::Net(_) => vec!["link failed".to_owned()],
        }
    }

    /// Returns whether `-Q` suppresses the preceding error message, as LinuxCNC does for errors of
    /// its library.
    pub(crate) const fn is_enough(&self) -> bool {
        matches!(self, Self::Plain(_))
    }
}

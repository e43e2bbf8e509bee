//! The error of a failed load.

use crate::Error;

/// The error of a failed load, with the component's name and its arguments' descriptions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loading {
    pub(crate) component: Box<str>,
    pub(crate) error: Error,
    /// The argument with the instance names, if a name is the cause.
    pub(crate) word: Option<Box<str>>,
    /// Descriptions of the arguments that the component may have refused.
    pub(crate) about: Option<Box<str>>,
}

impl Loading {
    /// Wraps an error, with the word that names the instances if a name is the cause.
    pub(crate) fn of(component: &str, words: &[String], error: Error) -> Error {
        let named = matches!(
            error,
            Error::Duplicate { .. } | Error::BadName { .. } | Error::NameTooLong { .. }
        );
        let word = words.iter().find(|w| named && w.starts_with("names"));
        let word = word.map(|w| w.replace('"', "").into());
        Error::Loading(Box::new(Self { component: component.into(), error, word, about: None }))
    }

    /// Returns a suggested correction.
    pub(crate) fn hint(&self) -> Option<String> {
        match (&self.error, &self.word) {
            (Error::Duplicate { .. } | Error::BadName { .. }, Some(_)) => {
                Some("expected names that are not taken, each once, such as names=a,b".to_owned())
            }
            _ => {
                let about = self.about.as_deref().map(str::to_owned);
                let all: Vec<String> = self.error.hint().into_iter().chain(about).collect();
                (!all.is_empty()).then(|| all.join("; "))
            }
        }
    }
}

impl core::fmt::Display for Loading {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match &self.error {
            // The message already names the component.
            Error::InitFailed { .. } | Error::OpenFailed { .. } => return self.error.fmt(f),
            other => write!(f, "{}: {other}", self.component)?,
        }
        match &self.word {
            Some(word) if word.len() <= 80 => write!(f, ", with `{word}'"),
            Some(word) => {
                write!(f, ", with {}=", word.split_once('=').map_or("names", |(name, _)| name))
            }
            None => Ok(()),
        }
    }
}

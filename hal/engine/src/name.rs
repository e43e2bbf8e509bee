//! Names, checked once.

use crate::Error;
use hal_abi::NAME_LEN;
use std::{borrow::Borrow, sync::Arc};

/// The name of a pin, parameter, signal, function, thread, component or command.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Name(Arc<str>);

impl Name {
    /// Checks a word that names a new `what`.
    pub(crate) fn parse(what: &'static str, word: &str) -> Result<Self, Error> {
        if word.len() > NAME_LEN {
            return Err(Error::NameTooLong { what, name: word.into() });
        }
        if word.is_empty() || word.chars().any(|c| c.is_whitespace() || c.is_control()) {
            return Err(Error::BadName { what, name: word.into() });
        }
        Ok(Self(word.into()))
    }

    /// The text.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

impl Borrow<str> for Name {
    fn borrow(&self) -> &str {
        &self.0
    }
}

impl core::fmt::Display for Name {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0)
    }
}

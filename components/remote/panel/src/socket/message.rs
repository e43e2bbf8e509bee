//! Messages of clients.

use crate::{
    commands::{self, Action, Args},
    engine::Ending,
    error::{Code, Error},
    scope::Wanted,
    session::Role,
};
use serde::Deserialize;
use serde_json::{Map, Value as Json};

/// Number of names that a client watches.
const MAX_WATCHED: usize = 1000;
/// Longest name in bytes.
const MAX_NAME: usize = 256;

/// A message of a client.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum Received {
    Hello {
        key: String,
    },
    Beat {
        n: u32,
    },
    /// A person uses the page.
    Input {},
    Watch {
        names: Vec<String>,
    },
    Lease {
        id: u64,
        #[serde(rename = "do")]
        action: LeaseAction,
        #[serde(default)]
        to: Option<u64>,
        #[serde(default)]
        force: bool,
    },
    Scope {
        id: u64,
        #[serde(default)]
        capture: Option<Wanted>,
    },
    Command {
        id: u64,
        name: String,
        #[serde(default)]
        args: Args,
    },
}

/// Returns the `id` of a message that cannot be read as one, if it has one.
pub(super) fn id(text: &str) -> Option<u64> {
    serde_json::from_str::<Json>(text).ok()?.get("id")?.as_u64()
}

impl Received {
    /// Returns the stop that it asks for, with the least role for it.
    pub(super) fn stop(&self) -> Option<(Ending, Role)> {
        let Self::Command { name, args, .. } = self else { return None };
        let row = commands::find(name).ok().filter(|_| args.is_empty())?;
        if let Action::Stop(ending) = row.action { Some((ending, row.role)) } else { None }
    }
}

/// Request of a client about the lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum LeaseAction {
    Take,
    Give,
    Hand,
}

/// Names that a client watches, with the values that it has.
#[derive(Debug, Default)]
pub(super) struct Watched {
    pub(super) names: Vec<String>,
    sent: Map<String, Json>,
}

impl Watched {
    pub(super) fn new(names: Vec<String>) -> Result<Self, Error> {
        if names.len() > MAX_WATCHED || names.iter().any(|name| name.len() > MAX_NAME) {
            let text = format!("at most {MAX_WATCHED} names of {MAX_NAME} bytes");
            return Err(Error::new(Code::TooLarge, text));
        }
        Ok(Self { names, sent: Map::new() })
    }

    /// Returns the values that differ from those that were sent.
    pub(super) fn changes(&mut self, now: Map<String, Json>) -> Map<String, Json> {
        let changed = now.iter().filter(|(name, value)| self.sent.get(*name) != Some(*value));
        let changed = changed.map(|(name, value)| (name.clone(), value.clone())).collect();
        self.sent = now;
        changed
    }
}

#[cfg(test)]
mod tests {
    //! Messages that cannot be read.

    use super::{Received, id};

    #[test]
    fn a_message_that_cannot_be_read_is_answered_if_it_has_an_id() {
        for (text, wanted) in [
            (r#"{"type": "scope", "id": 7, "names": []}"#, Some(7)),
            (r#"{"type": "lease", "id": 8, "do": "steal"}"#, Some(8)),
            (r#"{"type": "scope"}"#, None),
            (r#"{"type": "scope", "id": -1}"#, None),
            ("[7]", None),
            ("{", None),
        ] {
            serde_json::from_str::<Received>(text).unwrap_err();
            assert_eq!(id(text), wanted, "{text}");
        }
    }
}

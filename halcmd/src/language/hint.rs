//! Remedies for errors.

use crate::Error;

impl Error {
    /// Returns the remedy, if there is one.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Engine(failure) => failure.hint.clone(),
            Self::NoIniVariable { hint, .. } => Some(hint.to_string()),
            Self::NoHelp { word, near: None } if word.contains('.') => {
                Some(
                    "commands of a component are known while it is loaded; 'halcmd man COMPONENT' describes them"
                        .to_owned(),
                )
            }
            Self::UnknownCommand { near, .. }
            | Self::NoHelp { near, .. }
            | Self::NoCode { near, .. }
            | Self::NoManual { near, .. }
            | Self::NotLoaded { near, .. } => {
                near.as_ref().map(|near| format!("did you mean {near}?"))
            }
            Self::SignalType { .. } | Self::FilterType { .. } => {
                Some("it is one of bit, float, s32, u32, s64, u64, port".to_owned())
            }
            Self::AliasKind { word, .. } => {
                Some(format!("its first word is pin or param, not '{word}'"))
            }
            Self::Kind { kinds, .. } => Some(format!("it is one of {kinds}")),
            Self::Time { .. } => {
                Some("write a number and ns, us, ms or s, such as 20ms".to_owned())
            }
            Self::TooManyTokens => {
                Some(format!("at most {} words", crate::language::lex::MAX_WORDS))
            }
            Self::LineTooLong => Some(format!(
                "a line has at most {} bytes, and {} with the values of its variables",
                crate::MAX_PHYSICAL,
                crate::language::vars::MAX_LINE
            )),
            Self::NoDestination { why, .. }
            | Self::Ini(hal_ini::Error::File { why, .. })
            | Self::NoCommandFile { why, .. }
            | Self::NotApplied { why, .. } => Some(why.to_string()),
            Self::IniNotFound { folders, .. } => Some(format!("looked in {folders}")),
            Self::NoTask => Some(
                "a machine with motmod has one if its INI file has TASK = milltask in section TASK"
                    .to_owned(),
            ),
            Self::StandinUsed { .. } => Some(
                "start it with its hardware and its screen, or with --virtual, or take that line out"
                    .to_owned(),
            ),
            Self::NotYet { instead, .. } => Some((*instead).to_owned()),
            Self::NoTclsh => Some("apt-get install tcl".to_owned()),
            Self::LoadsDiffer { .. } => {
                Some("with TWOPASS all loadrt lines of a component become one".to_owned())
            }
            _ => None,
        }
    }

    /// Returns error and remedy in one line, for a program that ends with it.
    #[must_use]
    pub fn whole(&self) -> String {
        let text = self.to_string();
        let Some(hint) = self.hint() else { return text };
        format!("{}; {hint}", text.strip_suffix('.').unwrap_or(&text))
    }
}

/// Returns the name among `names` that `word` was probably meant to be: at most two characters differ.
pub(crate) fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<Box<str>> {
    hal_protocol::nearest(word, 2, names)
}

//! Remapped codes: subroutines that run in place of a code, as `[RS274NGC]REMAP` of an INI file asks.

mod parse;

use serde::{Deserialize, Serialize};

use crate::{
    function::Hook,
    interpret::codes::{self, MGroup},
};
pub use parse::Error;

/// A code that is remapped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Code {
    /// A G code, given as ten times its number.
    G(u16),
    /// An M code.
    M(u16),
    /// The words T, S and F.
    Word(u8),
}

/// A word that goes to the subroutine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Argument {
    /// The letter in lower case.
    pub letter: u8,
    /// The line must have the word.
    pub required: bool,
}

/// A remapped code with its subroutine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remap {
    /// The code.
    pub code: Code,
    /// The modal group that says when an M code runs: 5 to 10.
    pub group: u8,
    /// The words that the subroutine gets, in the order of `argspec`.
    pub arguments: Vec<Argument>,
    /// The words go to parameters 1 and up, not to named ones.
    pub positional: bool,
    /// The spindle speed must be above zero.
    pub needs_speed: bool,
    /// The feed must be above zero.
    pub needs_feed: bool,
    /// The line number goes to `#<n>`.
    pub line_number: bool,
    /// The subroutine; empty if a function runs instead.
    pub ngc: Box<str>,
    /// Functions of another language.
    pub hooks: Vec<(Hook, Box<str>)>,
}

impl Remap {
    /// Returns the function of this kind.
    pub fn hook(&self, hook: Hook) -> Option<&str> {
        self.hooks.iter().find(|(h, _)| *h == hook).map(|(_, name)| &**name)
    }

    /// Returns the group of an M code that is no other's.
    pub(crate) fn m_group(&self) -> MGroup {
        match self.group {
            4 => MGroup::Stop,
            5 => MGroup::Io,
            6 => MGroup::Tool,
            7 => MGroup::Spindle,
            8 => MGroup::Coolant,
            9 => MGroup::Override,
            _ => MGroup::User,
        }
    }
}

impl Code {
    /// Returns the number of an M code, or ten times that of a G code; a letter for a word.
    pub(crate) fn number(self) -> u16 {
        match self {
            Self::G(code) | Self::M(code) => code,
            Self::Word(letter) => u16::from(letter),
        }
    }

    /// Tells whether the code means something without a remap.
    pub(crate) fn is_of_the_language(self) -> bool {
        match self {
            Self::G(code) => codes::g_group(code).is_some(),
            Self::M(code) => codes::m_code(f64::from(code)).is_ok(),
            Self::Word(_) => true,
        }
    }

    /// Tells whether this is the M code with this number.
    pub(crate) fn is_m(self, value: f64) -> bool {
        matches!(self, Self::M(code) if f64::from(code) == value)
    }
}

impl core::fmt::Display for Code {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::G(code) if code % 10 == 0 => write!(f, "G{}", code / 10),
            Self::G(code) => write!(f, "G{}.{}", code / 10, code % 10),
            Self::M(code) => write!(f, "M{code}"),
            Self::Word(letter) => write!(f, "{}", char::from(letter.to_ascii_uppercase())),
        }
    }
}

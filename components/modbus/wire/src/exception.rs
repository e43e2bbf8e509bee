//! Reasons of a device to refuse a request.

use core::fmt;

/// Code with which a device refuses a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Exception(pub u8);

/// Codes of the standard, with their meaning.
const WORDS: &[(u8, &str)] = &[
    (1, "it does not know this function"),
    (2, "it has no such address"),
    (3, "it does not accept this value or number of elements"),
    (4, "it has failed to do it"),
    (5, "it has begun, and needs longer"),
    (6, "it is busy"),
    (7, "it cannot do it"),
    (8, "its memory has a parity error"),
    (10, "the gateway has no way to it"),
    (11, "the gateway has no answer of it"),
];

impl Exception {
    /// Returns the meaning of the code.
    #[must_use]
    pub fn words(self) -> &'static str {
        let known = WORDS.iter().find(|(code, _)| *code == self.0);
        known.map_or("its maker knows the reason", |(_, words)| words)
    }
}

impl fmt::Display for Exception {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the device refuses: {} (exception {})", self.words(), self.0)
    }
}

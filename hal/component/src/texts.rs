//! Texts of messages: the log and the results of commands take static ones.

use std::{
    collections::BTreeSet,
    sync::{Mutex, PoisonError},
};

/// Longest text in bytes.
const MAX_LEN: usize = 400;
/// Text in the place of those that are not kept.
const OTHER: &str = "too many different messages: the command NAME.status shows the last one";

/// Returns a text with the life of the process, which realtime messages need; equal texts are stored once. It is for texts that
/// a load makes; those that come from outside while the machine runs are bounded by [`Texts`].
#[must_use]
pub fn lasting(text: String) -> &'static str {
    static TEXTS: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
    let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = texts.get(text.as_str()) {
        return known;
    }
    let kept = text.leak();
    texts.insert(kept);
    kept
}

/// Texts that live as long as the process, each once.
#[derive(Debug)]
pub struct Texts {
    texts: BTreeSet<&'static str>,
    /// Largest number of texts.
    most: usize,
}

impl Texts {
    /// Returns an empty store for at most this many different texts.
    #[must_use]
    pub const fn new(most: usize) -> Self {
        Self { texts: BTreeSet::new(), most }
    }

    /// Returns the text with the life of the process. Braces, which mark pins and numbers in messages, become
    /// parentheses.
    pub fn keep(&mut self, text: &str) -> &'static str {
        let end = text.floor_char_boundary(MAX_LEN);
        let text = text.get(..end).unwrap_or_default().replace('{', "(").replace('}', ")");
        if let Some(known) = self.texts.get(text.as_str()) {
            return known;
        }
        if self.texts.len() >= self.most {
            return OTHER;
        }
        let kept = lasting(text);
        self.texts.insert(kept);
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_last_once() {
        let first = lasting("no answer {}".to_owned());
        assert_eq!(first, "no answer {}");
        assert!(core::ptr::eq(first, lasting("no answer {}".to_owned())));
        assert_eq!(lasting(String::new()), "");
    }

    #[test]
    fn each_text_is_kept_once_and_not_too_many() {
        let mut texts = Texts::new(100);
        let first = texts.keep("joint {0} is off");
        assert_eq!(first, "joint (0) is off");
        assert!(core::ptr::eq(first, texts.keep("joint {0} is off")));
        for n in 1..100 {
            assert_eq!(texts.keep(&n.to_string()), n.to_string());
        }
        assert_eq!(texts.keep("one more"), OTHER);
        assert!(core::ptr::eq(first, texts.keep("joint (0) is off")));
        assert!(Texts::new(1).keep(&"ä".repeat(300)).len() <= MAX_LEN);
    }
}

//! Texts of messages: the log and the results of commands take static ones.

use std::collections::BTreeSet;

/// Largest number of different texts that are kept.
const MAX_TEXTS: usize = 4096;
/// Longest text in bytes.
const MAX_LEN: usize = 400;
/// Text in the place of those that are not kept.
const OTHER: &str = "too many different messages: task.status shows the last one";

/// Texts that live as long as the process, each once.
#[derive(Debug, Default)]
pub(crate) struct Texts(BTreeSet<&'static str>);

impl Texts {
    /// Returns the text with the life of the process. Braces, which mark pins and numbers in messages, become
    /// parentheses.
    pub(crate) fn keep(&mut self, text: &str) -> &'static str {
        let end = text.floor_char_boundary(MAX_LEN);
        let text = text.get(..end).unwrap_or_default().replace('{', "(").replace('}', ")");
        if let Some(known) = self.0.get(text.as_str()) {
            return known;
        }
        if self.0.len() >= MAX_TEXTS {
            return OTHER;
        }
        let kept: &'static str = Box::leak(text.into_boxed_str());
        self.0.insert(kept);
        kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_text_is_kept_once_and_not_too_many() {
        let mut texts = Texts::default();
        let first = texts.keep("joint {0} is off");
        assert_eq!(first, "joint (0) is off");
        assert!(core::ptr::eq(first, texts.keep("joint {0} is off")));
        for n in 1..MAX_TEXTS {
            assert_eq!(texts.keep(&n.to_string()), n.to_string());
        }
        assert_eq!(texts.keep("one more"), OTHER);
        assert!(core::ptr::eq(first, texts.keep("joint (0) is off")));
        assert!(Texts::default().keep(&"ä".repeat(300)).len() <= MAX_LEN);
    }
}

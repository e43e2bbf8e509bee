//! Documentation texts of pins, parameters and functions. Each text is stored once.

use crate::sync::Arc;
use std::collections::BTreeMap;

/// Number of a documentation text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Doc(u32);

/// Documentation texts by number. Texts of unloaded components stay, because they are loaded again
/// with the same texts.
#[derive(Debug, Default)]
pub(crate) struct Docs {
    texts: Vec<Arc<str>>,
    numbers: BTreeMap<Arc<str>, Doc>,
}

impl Docs {
    /// Returns the number of a text. A text beyond the first 2^32 is not shown.
    pub(crate) fn number(&mut self, text: &str) -> Doc {
        if let Some(doc) = self.numbers.get(text) {
            return *doc;
        }
        let doc = Doc(u32::try_from(self.texts.len()).unwrap_or(u32::MAX));
        let text: Arc<str> = text.into();
        self.texts.push(text.clone());
        self.numbers.insert(text, doc);
        doc
    }

    /// Returns a text.
    pub(crate) fn text(&self, doc: Doc) -> &str {
        self.texts.get(doc.0 as usize).map_or("", |text| text)
    }
}

#[cfg(test)]
mod tests {
    use super::Docs;

    #[test]
    fn equal_texts_have_one_number() {
        let mut docs = Docs::default();
        let (first, second) = (docs.number("First input."), docs.number("Second input."));
        assert_eq!(docs.number("First input."), first);
        assert_eq!((docs.text(first), docs.text(second)), ("First input.", "Second input."));
        assert_eq!(docs.texts.len(), 2);
    }
}

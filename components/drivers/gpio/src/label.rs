//! Names of the kernel: of lines, chips and consumers.

use core::fmt;

/// Name of at most 31 bytes, which is the kernel's limit.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Label {
    bytes: [u8; Self::MOST],
    length: u8,
}

impl Label {
    /// Largest number of bytes.
    pub(crate) const MOST: usize = 31;
    /// Empty name.
    pub(crate) const NONE: Self = Self { bytes: [0; Self::MOST], length: 0 };

    /// Returns `text` as a name, or `None` if it is longer than the kernel's names.
    pub(crate) fn new(text: &str) -> Option<Self> {
        (text.len() <= Self::MOST).then(|| Self::cut(text))
    }

    /// Returns the beginning of `text` that fits, at most the first 31 bytes.
    pub(crate) fn cut(text: &str) -> Self {
        let text = text.get(..text.floor_char_boundary(Self::MOST)).unwrap_or_default();
        let mut label = Self::NONE;
        for (to, from) in label.bytes.iter_mut().zip(text.bytes()) {
            *to = from;
        }
        label.length = u8::try_from(text.len()).unwrap_or(0);
        label
    }

    /// Returns the text before the first zero byte of a name from the kernel; bytes that are no text end it as well.
    pub(crate) fn from_kernel(bytes: &[u8]) -> Self {
        let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
        let bytes = bytes.get(..end).unwrap_or_default();
        let text = match core::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(bad) => bytes
                .get(..bad.valid_up_to())
                .and_then(|good| core::str::from_utf8(good).ok())
                .unwrap_or_default(),
        };
        Self::cut(text)
    }

    pub(crate) fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..usize::from(self.length)).unwrap_or_default();
        core::str::from_utf8(bytes).unwrap_or_default()
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.length == 0
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

/// Returns the name nearest to `word`, at most two characters away, whatever its case.
pub(crate) fn nearest(word: Label, names: impl IntoIterator<Item = Label>) -> Option<Label> {
    let lower = word.as_str().to_lowercase();
    let distance =
        |name: &Label| strsim::damerau_levenshtein(&lower, &name.as_str().to_lowercase());
    // At least one character remains.
    let most = 2.min(lower.chars().count().saturating_sub(1));
    names
        .into_iter()
        .filter(|name| !name.is_empty() && *name != word)
        .map(|name| (distance(&name), name))
        .filter(|(away, _)| *away <= most)
        .min()
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::{Label, nearest};

    #[test]
    fn names_from_the_kernel_end_at_a_zero_or_at_what_is_no_text() {
        for (bytes, text) in [
            (&b"GPIO17\0rest"[..], "GPIO17"),
            (b"", ""),
            (b"\0", ""),
            (b"pin\xFFx", "pin"),
            (&[b'x'; 40], "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"),
        ] {
            assert_eq!(Label::from_kernel(bytes).as_str(), text);
        }
        assert_eq!(Label::cut(&"ä".repeat(20)).as_str(), "ä".repeat(15));
        assert_eq!((Label::new(&"x".repeat(32)), Label::new("x").is_some()), (None, true));
    }

    #[test]
    fn near_names() {
        let names = ["GPIO17", "GPIO27", "ID_SDA", "A", ""].map(Label::cut);
        for (word, near) in [
            ("GPOI17", Some("GPIO17")),
            ("gpio27", Some("GPIO27")),
            ("ID_SDL", Some("ID_SDA")),
            ("PIN11", None),
            ("a", Some("A")),
            ("%", None),
            ("", None),
        ] {
            let found = nearest(Label::cut(word), names);
            assert_eq!(found.as_ref().map(Label::as_str), near, "{word}");
        }
    }
}

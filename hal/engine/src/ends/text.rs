//! Text that is put together without memory from the heap: signal handlers do so.

use core::fmt;

/// A text of at most so many bytes; what is longer is cut.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Text {
    bytes: [u8; 480],
    len: usize,
}

impl Text {
    /// An empty one.
    pub(crate) const fn new() -> Self {
        Self { bytes: [0; 480], len: 0 }
    }

    /// Adds what `format_args!` makes.
    pub(crate) fn add(&mut self, what: fmt::Arguments<'_>) {
        // What does not fit is cut: that is no error.
        fmt::Write::write_fmt(self, what).unwrap_or_default();
    }

    /// The text.
    pub(crate) fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.len).unwrap_or_default();
        // Cut inside a letter: up to there.
        core::str::from_utf8(bytes).unwrap_or_else(|e| {
            let good = bytes.get(..e.valid_up_to()).unwrap_or_default();
            core::str::from_utf8(good).unwrap_or_default()
        })
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let rest = self.bytes.get_mut(self.len..).unwrap_or_default();
        for (place, byte) in rest.iter_mut().zip(text.bytes()) {
            *place = byte;
            self.len += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Text;

    #[test]
    fn what_does_not_fit_is_cut_between_letters() {
        let mut text = Text::new();
        text.add(format_args!("{} {:#x}", "one", 255));
        assert_eq!(text.as_str(), "one 0xff");
        for _ in 0..300 {
            text.add(format_args!("ä"));
        }
        assert_eq!(text.as_str(), format!("one 0xff{}", "ä".repeat(236)));
        let mut text = Text::new();
        text.add(format_args!("{}ä", "x".repeat(479)));
        assert_eq!(text.as_str(), "x".repeat(479));
    }
}

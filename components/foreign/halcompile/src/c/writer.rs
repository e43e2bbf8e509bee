//! Writer of C lines, with `#line` marks that lead the compiler's messages to the .comp file.

use super::quoted;

/// C text written so far.
pub(crate) struct Writer<'a> {
    source: &'a str,
    out: &'a str,
    text: String,
    /// Number of lines written so far.
    lines: usize,
}

impl<'a> Writer<'a> {
    /// Makes an empty writer; `source` and `out` are the two files as messages name them.
    pub(crate) const fn new(source: &'a str, out: &'a str) -> Self {
        Self { source, out, text: String::new(), lines: 0 }
    }

    /// Writes a line, or several.
    pub(crate) fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
        self.lines += 1 + text.matches('\n').count();
    }

    /// Writes a line that comes from this line of the .comp file.
    pub(crate) fn at(&mut self, line: usize, text: &str) {
        self.user(text, line);
    }

    /// Writes the user's own text, which begins on this line of the .comp file.
    pub(crate) fn user(&mut self, text: &str, line: usize) {
        self.line(&format!("#line {line} {}", quoted(self.source)));
        self.line(text.trim_end_matches('\n'));
        let next = self.lines + 2;
        self.line(&format!("#line {next} {}", quoted(self.out)));
    }

    /// Returns the whole text.
    pub(crate) fn finish(self) -> String {
        self.text
    }
}

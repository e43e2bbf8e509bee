//! Lines of C, with marks that lead the compiler's messages to the .comp file.

use super::quoted;

/// What is written so far.
pub(crate) struct Writer<'a> {
    source: &'a str,
    out: &'a str,
    text: String,
    /// Lines so far.
    lines: usize,
}

impl<'a> Writer<'a> {
    /// Nothing yet; the two files as messages name them.
    pub(crate) const fn new(source: &'a str, out: &'a str) -> Self {
        Self { source, out, text: String::new(), lines: 0 }
    }

    /// A line, or several.
    pub(crate) fn line(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push('\n');
        self.lines += 1 + text.matches('\n').count();
    }

    /// A line that comes from this line of the .comp file.
    pub(crate) fn at(&mut self, line: usize, text: &str) {
        self.user(text, line);
    }

    /// Text of the user's, which begins on this line of the .comp file.
    pub(crate) fn user(&mut self, text: &str, line: usize) {
        self.line(&format!("#line {line} {}", quoted(self.source)));
        self.line(text.trim_end_matches('\n'));
        let next = self.lines + 2;
        self.line(&format!("#line {next} {}", quoted(self.out)));
    }

    /// All of it.
    pub(crate) fn finish(self) -> String {
        self.text
    }
}

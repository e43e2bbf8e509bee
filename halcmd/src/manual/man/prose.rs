//! The parts of a component's documentation.

/// The documentation of a component, split into its parts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Doc {
    /// Summary, in a line.
    pub(super) summary: String,
    /// Paragraphs, each in one line, except for lists and tables.
    pub(super) paragraphs: Vec<String>,
    /// `loadrt` lines with other arguments than the example, for the pins that these arguments
    /// make.
    pub(super) pins: Vec<String>,
    /// Text before the example.
    pub(super) before: Vec<String>,
    /// Example script.
    pub(super) example: Option<String>,
}

impl Doc {
    /// Splits a documentation text.
    pub(super) fn of(doc: &str) -> Self {
        let (summary, rest) = doc.split_once('\n').unwrap_or((doc, ""));
        let (about, example) = rest.split_once("# Example\n").unwrap_or((rest, ""));
        let (about, pins) = about.split_once("# Pins\n").unwrap_or((about, ""));
        let (before, lines) = script(example);
        Self {
            summary: summary.trim().to_owned(),
            paragraphs: paragraphs(about),
            pins: script(pins).1,
            before: paragraphs(before),
            example: (!lines.is_empty()).then(|| lines.join("\n") + "\n"),
        }
    }
}

/// Splits the text before a script from the lines of the script.
fn script(text: &str) -> (&str, Vec<String>) {
    let (before, code) = text.split_once("```hal\n").unwrap_or((text, ""));
    let lines = code.split_once("```").map(|(script, _)| script.lines());
    (before, lines.into_iter().flatten().map(|l| l.trim().to_owned()).collect())
}

/// Splits a text into paragraphs. Lines of lists and tables stay separate lines.
fn paragraphs(text: &str) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut open = false;
    for line in text.lines().map(str::trim) {
        let is_own = line.starts_with(['|', '#']) || starts_list(line);
        if line.is_empty() {
            open = false;
        } else if let Some(last) = out.last_mut().filter(|_| open && !is_own) {
            last.push(' ');
            last.push_str(line);
        } else {
            out.push(line.to_owned());
            open = !line.starts_with('|');
        }
    }
    out
}

fn starts_list(line: &str) -> bool {
    line.starts_with("- ") || line.starts_with("* ")
}

#[cfg(test)]
mod tests {
    use super::Doc;

    #[test]
    fn parts() {
        let doc = "What it is.\n\nOne\nparagraph.\n\n- a list\n  of two\n- lines\n\n| a | b |\n|---|---|\n\n\
            # Pins\n\n```hal\nloadrt x cfg=2\n```\n\n# Example\n\nIt works so.\n\n```hal\nloadrt x\n getp x.0.out # -> 1\n```\n";
        let doc = Doc::of(doc);
        assert_eq!(doc.summary, "What it is.");
        assert_eq!(
            doc.paragraphs,
            ["One paragraph.", "- a list of two", "- lines", "| a | b |", "|---|---|"]
        );
        assert_eq!(doc.pins, ["loadrt x cfg=2"]);
        assert_eq!(doc.before, ["It works so."]);
        assert_eq!(doc.example.as_deref(), Some("loadrt x\ngetp x.0.out # -> 1\n"));
        assert_eq!(Doc::of("Alone.").example, None);
        assert_eq!(Doc::of("").summary, "");
    }
}

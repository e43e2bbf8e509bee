//! Colours of errors and of the marks under a line, and texts that cannot change the terminal.

/// Returns a text with a dot for each control character, which could affect the terminal.
pub(crate) fn visible(text: &str) -> String {
    text.chars().map(|c| if c.is_control() && c != '\t' { '·' } else { c }).collect()
}

/// Colours the message of an error.
pub(crate) fn error(text: &str, coloured: bool) -> String {
    if coloured { format!("\x1b[31m{text}\x1b[0m") } else { text.to_owned() }
}

/// Colours the marks under a line of a script.
pub(crate) fn mark(excerpt: &str, coloured: bool) -> String {
    let lines = excerpt.split_inclusive('\n');
    let is_mark = |line: &str| {
        line.contains('^') && line.trim_matches(['^', '|', ' ', '\t', '…', '\n']).is_empty()
    };
    lines
        .map(|line| match line.strip_suffix('\n') {
            Some(bare) if coloured && is_mark(line) => format!("\x1b[1;31m{bare}\x1b[0m\n"),
            _ => line.to_owned(),
        })
        .collect()
}

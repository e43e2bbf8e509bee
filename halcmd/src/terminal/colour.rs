//! Colours of errors and of the marks under a line, and texts that cannot change the terminal.

/// Returns a text with a dot for each control character that could change the terminal: all but the ends of lines and tabs.
pub(crate) fn visible(text: &str) -> String {
    let is_text = |c: char| !c.is_control() || matches!(c, '\t' | '\n');
    text.chars().map(|c| if is_text(c) { c } else { '·' }).collect()
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

#[cfg(test)]
mod tests {
    //! Text of a file at a terminal.

    use super::visible;

    #[test]
    fn control_characters_are_dots() {
        assert_eq!(visible("a\x1b[2J\tb\u{9b}c\r\nd\0"), "a·[2J\tb·c·\nd·");
    }
}

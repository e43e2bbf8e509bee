//! Detection of a person at the terminal, and of colours.

use std::{env, os::fd::AsFd};

/// Returns whether a person types and reads at a terminal that can move its cursor.
pub(crate) fn is_person() -> bool {
    let both =
        rustix::termios::isatty(std::io::stdin()) && rustix::termios::isatty(std::io::stdout());
    both && is_able()
}

/// Returns whether output to this file descriptor may be coloured.
pub(crate) fn wanted(fd: impl AsFd) -> bool {
    let refused = env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
    !refused && rustix::termios::isatty(fd) && is_able()
}

fn is_able() -> bool {
    env::var("TERM").is_ok_and(|term| !matches!(term.as_str(), "" | "dumb"))
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

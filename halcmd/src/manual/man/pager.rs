//! Output through the user's pager.

use std::{
    env,
    io::Write,
    process::{Command, Stdio},
};

/// Shows the text. Returns false if there is no pager.
pub(super) fn show(text: &str) -> bool {
    let asked = ["MANPAGER", "PAGER"].iter().find_map(|name| env::var(name).ok());
    let asked = asked.filter(|pager| !pager.trim().is_empty());
    let pager = asked.unwrap_or_else(|| "less".to_owned());
    let mut words = pager.split_whitespace();
    let Some(program) = words.next() else { return false };
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::piped());
    if env::var_os("LESS").is_none() {
        // A page that fits is printed without paging, and the text stays on the screen.
        command.env("LESS", "FRX");
    }
    let Ok(mut child) = command.spawn() else { return false };
    if let Some(mut to) = child.stdin.take() {
        // Leaving the pager early is not an error.
        to.write_all(text.as_bytes()).unwrap_or_default();
    }
    child.wait().is_ok()
}

//! Text through the pager that a person has.

use std::{
    env,
    io::Write,
    process::{Command, Stdio},
};

/// Shows it; false where there is no pager.
pub(super) fn show(text: &str) -> bool {
    let asked = ["MANPAGER", "PAGER"].iter().find_map(|name| env::var(name).ok());
    let asked = asked.filter(|pager| !pager.trim().is_empty());
    let pager = asked.unwrap_or_else(|| "less".to_owned());
    let mut words = pager.split_whitespace();
    let Some(program) = words.next() else { return false };
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::piped());
    if env::var_os("LESS").is_none() {
        // A page that fits is printed; what was shown stays on the screen.
        command.env("LESS", "FRX");
    }
    let Ok(mut child) = command.spawn() else { return false };
    if let Some(mut to) = child.stdin.take() {
        // A pager that is left early is no error.
        to.write_all(text.as_bytes()).unwrap_or_default();
    }
    child.wait().is_ok()
}

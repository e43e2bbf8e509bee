//! The history of typed lines, in a file of the user.

use rustyline::{Editor, Helper, history::FileHistory};
use std::{
    env, fs,
    os::unix::fs::DirBuilderExt,
    path::{Path, PathBuf},
};

/// Returns `ferrule/history` in the user's state folder, which it creates if necessary. Returns
/// `None` without a home folder.
pub(super) fn file() -> Option<PathBuf> {
    let absolute = |name: &str| env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let state =
        absolute("XDG_STATE_HOME").or_else(|| Some(absolute("HOME")?.join(".local/state")))?;
    let folder = state.join("ferrule");
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true).mode(0o700).create(&folder).ok()?;
    Some(folder.join("history"))
}

/// Appends the last line, keeping lines that other prompts have appended. Errors are ignored,
/// because a missing history should not stop the prompt.
pub(super) fn keep<H: Helper>(editor: &mut Editor<H, FileHistory>, file: &Path) {
    let kept = if file.exists() { editor.append_history(file) } else { editor.save_history(file) };
    drop(kept);
}

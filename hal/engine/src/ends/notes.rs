//! Notes for the watcher, as lines of text.

use super::board::{board, lost};
use crate::{name::Name, sync::Ordering};

/// Notes that the watcher need not report the end of this process.
pub(super) fn have_told() {
    if let Some(board) = board() {
        board.untold.store(0, Ordering::Relaxed);
    }
}

/// Adds a line to the text that the watcher reads.
pub(super) fn note(line: core::fmt::Arguments<'_>) {
    if let Some(board) = board() {
        board.add(&line.to_string());
    }
}

/// Tells the watcher the number of a component's function.
pub(crate) fn note_funct(number: u32, component: &Name, funct: &Name) {
    note(format_args!("f {number} component '{component}', function '{funct}'"));
}

/// Tells the watcher that a component has begun threads of its own, or is gone together with them.
pub(crate) fn note_own_threads(component: &Name, there: bool) {
    note(format_args!("o {} {component}", i32::from(there)));
}

/// Tells the watcher the file of the recording, which has lost nothing yet.
pub(crate) fn note_recording(path: &str, inode: u64) {
    lost().into_iter().for_each(|lost| lost.store(0, Ordering::Relaxed));
    let here = std::env::current_dir().unwrap_or_default().join(path);
    note(format_args!("r {inode} {}", here.display()));
}

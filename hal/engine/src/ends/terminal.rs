//! The terminal as it was found: a process that ends while somebody edits a line leaves it so.

use crate::sync::{AtomicPtr, Ordering};
use core::{mem::MaybeUninit, ptr::null_mut};

/// How the terminal was found.
static TERMINAL: AtomicPtr<libc::termios> = AtomicPtr::new(null_mut());

/// Notes how the terminal is, if there is one.
pub(super) fn keep() {
    let mut found = MaybeUninit::<libc::termios>::zeroed();
    // SAFETY: a place for the state.
    if unsafe { libc::tcgetattr(libc::STDIN_FILENO, found.as_mut_ptr()) } == 0 {
        // SAFETY: filled by the system.
        let found = unsafe { found.assume_init() };
        TERMINAL.store(Box::into_raw(Box::new(found)), Ordering::Release); // Pairs with below.
    }
}

/// Puts the terminal right again, unless other programs have it.
pub(super) fn restore() {
    let found = TERMINAL.load(Ordering::Acquire); // Pairs with `keep`.
    // SAFETY: a request to the system.
    let holder = unsafe { libc::tcgetpgrp(libc::STDIN_FILENO) };
    // SAFETY: as above.
    let ours = holder == unsafe { libc::getpgrp() };
    if !found.is_null() && ours {
        // SAFETY: kept for good by `keep`.
        unsafe { libc::tcsetattr(libc::STDIN_FILENO, libc::TCSANOW, found) };
    }
}

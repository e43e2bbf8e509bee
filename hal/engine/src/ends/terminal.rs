//! The state of the terminal at the start. A process that ends while a user edits a line restores
//! it.

use crate::sync::{AtomicPtr, Ordering};
use core::{mem::MaybeUninit, ptr::null_mut};

/// State of the terminal at the start.
static TERMINAL: AtomicPtr<libc::termios> = AtomicPtr::new(null_mut());

/// Saves the state of the terminal, if there is one.
pub(super) fn keep() {
    let mut found = MaybeUninit::<libc::termios>::zeroed();
    // SAFETY: a place for the state.
    if unsafe { libc::tcgetattr(libc::STDIN_FILENO, found.as_mut_ptr()) } == 0 {
        // SAFETY: filled by the system.
        let found = unsafe { found.assume_init() };
        TERMINAL.store(Box::into_raw(Box::new(found)), Ordering::Release); // Pairs with below.
    }
}

/// Restores the terminal, unless another program is in its foreground.
pub(super) fn restore() {
    let found = TERMINAL.load(Ordering::Acquire); // Pairs with `keep`.
    // SAFETY: a request to the system.
    let holder = unsafe { libc::tcgetpgrp(libc::STDIN_FILENO) };
    // SAFETY: as above.
    let ours = holder == unsafe { libc::getpgrp() };
    if !found.is_null() && ours {
        // SAFETY: saved by `keep` and never freed.
        unsafe { libc::tcsetattr(libc::STDIN_FILENO, libc::TCSANOW, found) };
    }
}

//! The process whose end is handled: whether it is this one, whether its control side must return,
//! and which thread ends it.

use super::sys;
use crate::sync::{AtomicBool, AtomicI32, Ordering};

/// Process ID of the process whose termination is handled; 0 if none. A forked copy of the process
/// has another ID.
pub(super) static OURS: AtomicI32 = AtomicI32::new(0);
/// Thread ID of the guard; 0 if none.
pub(super) static GUARD: AtomicI32 = AtomicI32::new(0);
/// Set when the control side must return from what it is doing.
static WANTED: AtomicBool = AtomicBool::new(false);
/// Event descriptor that becomes readable when [`WANTED`] is set; -1 if none.
pub(super) static WAKE: AtomicI32 = AtomicI32::new(-1);
/// Thread ID of the thread that ends this process; 0 if none.
static CLAIM: AtomicI32 = AtomicI32::new(0);

/// Returns whether this process is the one whose termination is handled, and not a copy that a
/// component forked.
pub(super) fn is_ours() -> bool {
    let ours = OURS.load(Ordering::Relaxed);
    ours != 0 && ours == sys::process()
}

/// Asks the control side to return from what it is doing.
pub(super) fn want() {
    WANTED.store(true, Ordering::Relaxed);
    sys::wake(WAKE.load(Ordering::Relaxed));
}

/// Realtime. Returns whether the control side must return from what it is doing.
#[inline]
pub(crate) fn is_wanted() -> bool {
    WANTED.load(Ordering::Relaxed)
}

/// Returns the descriptor that becomes readable when the control side must return from what it is
/// doing, if there is one.
pub(crate) fn wake() -> Option<std::os::fd::BorrowedFd<'static>> {
    let fd = WAKE.load(Ordering::Relaxed);
    // SAFETY: it is never closed.
    (fd >= 0).then(|| unsafe { std::os::fd::BorrowedFd::borrow_raw(fd) })
}

/// Returns whether the process is about to end, in which case no other thread may do anything more.
pub(crate) fn is_claimed() -> bool {
    // Pairs with `claim`: a thread that has unpublished something before sees whether another one
    // may still read it.
    CLAIM.load(Ordering::SeqCst) != 0
}

/// Waits for the end of the process.
pub(crate) fn park() -> ! {
    loop {
        sys::nap(1000);
    }
}

pub(super) fn claim() -> bool {
    let me = sys::thread();
    // Pairs with `is_claimed`.
    match CLAIM.compare_exchange(0, me, Ordering::SeqCst, Ordering::SeqCst) {
        Ok(_) => true,
        Err(other) if other == me => false,
        Err(_) => park(),
    }
}

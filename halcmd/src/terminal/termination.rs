//! Signals that end a program, either at once or after the terminal has been restored.

use signal_hook::{
    consts::{SIGHUP, SIGINT, SIGTERM},
    flag, low_level,
};
use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};

/// Signal handling of this process, if [`leave_on_signals`] was called.
static LEAVING: OnceLock<Leaving> = OnceLock::new();

struct Leaving {
    /// True if a signal ends the process at once.
    at_once: Arc<AtomicBool>,
    /// True if a signal has arrived.
    come: Arc<AtomicBool>,
    /// Exit status.
    status: i32,
}

/// Makes this process exit with this status as soon as the user or the system requests it. The
/// engine notices that the socket is closed.
pub fn leave_on_signals(status: i32) {
    let leaving = LEAVING.get_or_init(|| Leaving {
        at_once: Arc::new(AtomicBool::new(true)),
        come: Arc::new(AtomicBool::new(false)),
        status,
    });
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // A signal that cannot be caught keeps its own effect, which is to end the process.
        drop(flag::register_conditional_shutdown(signal, status, Arc::clone(&leaving.at_once)));
        drop(flag::register(signal, Arc::clone(&leaving.come)));
    }
}

/// Returns a flag that is set when the user or the system asks this process to end.
#[must_use]
pub fn ending_flag() -> Arc<AtomicBool> {
    let ending = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        drop(flag::register(signal, Arc::clone(&ending)));
    }
    ending
}

/// While it exists, signals do not end this process at once; a signal that arrives meanwhile ends
/// it afterwards. For code that changes the terminal.
#[derive(Debug)]
pub(crate) struct Held(());

impl Held {
    pub(crate) fn new() -> Self {
        set_at_once(false);
        Self(())
    }

    /// Returns whether a signal has arrived.
    pub(crate) fn has_come(&self) -> bool {
        // Pairs with the store in the signal handler.
        LEAVING.get().is_some_and(|leaving| leaving.come.load(Ordering::SeqCst))
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        set_at_once(true);
        if self.has_come() {
            interrupt();
        }
    }
}

/// Handles Ctrl-C where the terminal delivers it as a key: asks this process to end.
pub(crate) fn interrupt() {
    match LEAVING.get() {
        Some(leaving) => low_level::exit(leaving.status),
        // Raised on this thread, so that it has arrived when this returns. SIGINT can always be
        // raised.
        None => low_level::raise(SIGINT).unwrap_or_default(),
    }
}

fn set_at_once(yes: bool) {
    if let Some(leaving) = LEAVING.get() {
        // Pairs with the load in the signal handler.
        leaving.at_once.store(yes, Ordering::SeqCst);
    }
}

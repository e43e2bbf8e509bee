//! Signals that end a program: at once, or as soon as the terminal is as it was found.

use signal_hook::{
    consts::{SIGHUP, SIGINT, SIGTERM},
    flag, low_level,
};
use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};

/// What the signals of this process do, if it asked for that.
static LEAVING: OnceLock<Leaving> = OnceLock::new();

struct Leaving {
    /// Whether one ends the process at once.
    at_once: Arc<AtomicBool>,
    /// Whether one has come.
    come: Arc<AtomicBool>,
    /// With which status it ends.
    status: i32,
}

/// Leaves with this status as soon as the user or the system asks this process to end. The engine
/// notices that the socket is closed.
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

/// A flag that is set when the user or the system asks this process to end.
#[must_use]
pub fn ending_flag() -> Arc<AtomicBool> {
    let ending = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        drop(flag::register(signal, Arc::clone(&ending)));
    }
    ending
}

/// While it lives, signals do not end this process at once; if one has come meanwhile, it does
/// afterwards. For those who change the terminal.
#[derive(Debug)]
pub(crate) struct Held(());

impl Held {
    pub(crate) fn new() -> Self {
        set_at_once(false);
        Self(())
    }

    /// Whether one has come.
    pub(crate) fn has_come(&self) -> bool {
        // Pairs with the store that signals make.
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

/// Ctrl-C, where the terminal gives it as a key: asks this process to end, as it does elsewhere.
pub(crate) fn interrupt() {
    match LEAVING.get() {
        Some(leaving) => low_level::exit(leaving.status),
        // On this thread, so that it has come before this returns. SIGINT can always be raised.
        None => low_level::raise(SIGINT).unwrap_or_default(),
    }
}

fn set_at_once(yes: bool) {
    if let Some(leaving) = LEAVING.get() {
        // Pairs with the look that signals take.
        leaving.at_once.store(yes, Ordering::SeqCst);
    }
}

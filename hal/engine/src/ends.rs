//! Termination of an instance's process by a signal, by a crash, or by a component that calls a
//! function such as `exit`. In every case the outputs are driven to their safe levels, the cause is
//! reported, recordings are kept, and the socket is removed.
//!
//! [`Ends`] is the entry point. `signals.rs` handles signals and `exits.rs` replaces the C
//! library's functions; both lead to `crash.rs`. The thread of `guard.rs` does what a signal
//! handler must not do, and ends the process when the control side does not respond. `process.rs`
//! and `instance.rs` hold what all of them read, `doing.rs` the component code that runs.

pub(crate) mod ending;

mod apart;
mod board;
mod crash;
mod doing;
mod exits;
mod guard;
mod instance;
pub(crate) mod maps;
mod notes;
mod process;
mod signals;
mod sys;
mod terminal;
mod text;
mod watcher;
mod who;

pub(crate) use apart::threads;
pub(crate) use board::{Current, NOBODY, lost, record};
pub(crate) use doing::{
    Activity, Control, Doing, Origin, begin_cycle, end_cycle, run_stop, run_worker,
};
pub(crate) use instance::{Instance, Remains};
pub(crate) use notes::{note_funct, note_own_threads, note_recording};
pub(crate) use process::{is_claimed, is_wanted, park, wake};
pub(crate) use signals::is_asked;
pub(crate) use sys::Stack;

use crate::sync::Ordering;
use process::{OURS, WAKE};
use watcher::Watcher;

/// Guard object: while it lives, the termination of this process is handled.
#[derive(Debug)]
pub struct Ends {
    #[expect(dead_code, reason = "the main thread attends to crashes on it")]
    stack: Stack,
    watcher: Option<Watcher>,
}

impl Ends {
    /// Begins to handle the termination of the process. The program must be one instance and
    /// nothing else, and must call this from its main thread before it starts another thread.
    #[must_use]
    pub fn begin(program: &str) -> Self {
        board::make();
        let watcher = Watcher::begin(program);
        terminal::keep();
        // Before any thread is started.
        crate::os::process::keep_continue();
        let stack = Stack::new();
        WAKE.store(sys::waker(), Ordering::Relaxed);
        OURS.store(sys::process(), Ordering::Relaxed);
        exits::watch();
        signals::watch();
        guard::begin();
        Self { stack, watcher }
    }

    /// Ends the handling after the instance has shut down in good order. Returns the exit status of
    /// the process, unless the process was asked to end by a signal that is not meant for
    /// instances; the process then ends by that signal.
    #[must_use]
    pub fn finish(self, status: u8) -> u8 {
        drop(self);
        if let Some((signal, _)) = signals::asked()
            && signals::is_unmeant(signal)
        {
            sys::die(signal);
        }
        status
    }

    /// Detaches the watcher from standard error, so that a reader of this process's output sees its
    /// end. From now on the watcher prints to the file `log`.
    pub fn be_quiet(&self, log: Option<&std::path::Path>) {
        log.into_iter().for_each(|log| notes::note(format_args!("l 0 {}", log.display())));
        self.watcher.iter().for_each(Watcher::be_quiet);
    }

    /// Returns the message about the signal that has asked this process to end, if that signal is
    /// not meant for instances.
    #[must_use]
    pub fn said(&self) -> Option<String> {
        let (signal, sender) = signals::asked()?;
        let by = sender.map_or_else(String::new, |by| format!(", sent by process {by}"));
        let said = || format!("{}{by}: the instance ends", signals::Named(signal));
        signals::is_unmeant(signal).then(said)
    }
}

impl Drop for Ends {
    fn drop(&mut self) {
        notes::have_told();
        OURS.store(0, Ordering::Relaxed);
        signals::unwatch();
    }
}

//! Termination of an instance's process by a signal, by a crash, or by a component that calls a
//! function such as `exit`. In every case the outputs are driven to their safe levels, the cause is
//! reported, recordings are kept, and the socket is removed.
//!
//! [`Ends`] is the entry point. `signals.rs` handles signals and `exits.rs` replaces the C
//! library's functions; both lead to `crash.rs`. The thread of `guard.rs` does what a signal
//! handler must not do, and ends the process when the control side does not respond.

pub(crate) mod ending;

mod apart;
mod board;
mod crash;
mod exits;
mod guard;
pub(crate) mod maps;
mod signals;
mod sys;
mod terminal;
mod text;
mod watcher;
mod who;

pub(crate) use apart::threads;
pub(crate) use board::{Current, NOBODY, lost, record};
pub(crate) use crash::{is_claimed, park};
pub(crate) use sys::Stack;
pub(crate) use who::{Control, Doing, Origin, What, begin_cycle, end_cycle, run_stop};

use crate::{
    load::code::Code,
    name::Name,
    observe::flight::Flight,
    observe::record::Tape,
    realtime::shared::Shared,
    sync::{Arc, AtomicBool, AtomicI32, AtomicPtr, Ordering},
};
use core::ptr::null_mut;
use hal_abi::CommandRun;
use hal_protocol::Place;
use std::{
    ffi::CString,
    os::unix::ffi::OsStrExt,
    sync::{Mutex, MutexGuard, PoisonError},
};
use watcher::Watcher;

/// Process ID of the process whose termination is handled; 0 if none. A forked copy of the process
/// has another ID.
static OURS: AtomicI32 = AtomicI32::new(0);
/// Thread ID of the guard; 0 if none.
static GUARD: AtomicI32 = AtomicI32::new(0);
/// Set when the control side must return from what it is doing.
static WANTED: AtomicBool = AtomicBool::new(false);
/// Event descriptor that becomes readable when [`WANTED`] is set; -1 if none.
static WAKE: AtomicI32 = AtomicI32::new(-1);
/// The instances of this process, for threads that may wait.
static KNOWN: Mutex<Vec<Arc<Instance>>> = Mutex::new(Vec::new());
/// The instances of this process, for the thread that has claimed the termination. Only tests have
/// more than one.
static INSTANCES: [AtomicPtr<Instance>; 32] = [const { AtomicPtr::new(null_mut()) }; 32];

/// Data of an instance that is needed when its process ends.
#[derive(Debug)]
pub(crate) struct Instance {
    name: Box<str>,
    shared: Arc<Shared>,
    /// Paths of its socket and of its lock file.
    files: Vec<CString>,
    /// Thread ID of the control side.
    thread: AtomicI32,
    pub(crate) control: Control,
    remains: AtomicPtr<Remains>,
    saved: Mutex<Saved>,
}

/// Everything that is loaded.
#[derive(Debug, Default)]
pub(crate) struct Remains {
    /// Every stop action.
    pub(crate) stops: Vec<Arc<Code<CommandRun>>>,
    /// Origin of each component.
    pub(crate) origins: Vec<Origin>,
    /// Names of components, by their IDs.
    pub(crate) names: Vec<(u32, Name)>,
}

/// Recordings and programs that are attended to when the process ends.
#[derive(Debug, Default)]
struct Saved {
    tape: Option<Arc<Mutex<Tape>>>,
    flight: Option<Arc<Mutex<Flight>>>,
    /// Programs that the instance has started.
    programs: Vec<i32>,
}

impl Instance {
    /// Creates an instance that is not yet registered.
    pub(crate) fn new(shared: Arc<Shared>, place: &Place) -> Arc<Self> {
        let path = |p: std::path::PathBuf| CString::new(p.as_os_str().as_bytes()).ok();
        Arc::new(Self {
            name: place.name().into(),
            shared,
            files: [place.socket(), place.lock()].into_iter().filter_map(path).collect(),
            thread: AtomicI32::new(sys::thread()),
            control: Control::default(),
            remains: AtomicPtr::new(null_mut()),
            saved: Mutex::default(),
        })
    }

    /// Registers the instance once it has its socket.
    pub(crate) fn attend(self: &Arc<Self>) {
        all_known().push(self.clone());
        let mine = Arc::into_raw(self.clone()).cast_mut();
        for place in &INSTANCES {
            // Pairs with `instances`.
            let order = (Ordering::SeqCst, Ordering::Relaxed);
            if place.compare_exchange(null_mut(), mine, order.0, order.1).is_ok() {
                self.note();
                return;
            }
        }
        // SAFETY: made above and published nowhere.
        drop(unsafe { Arc::from_raw(mine) });
    }

    fn note(&self) {
        note(format_args!("i 0 {}", self.name));
        for file in &self.files {
            note(format_args!("s 0 {}", file.to_string_lossy()));
        }
        if let Some(board) = board::board() {
            board.untold.store(1, Ordering::Relaxed);
        }
    }

    /// Removes the instance from the register.
    pub(crate) fn leave(self: &Arc<Self>) {
        all_known().retain(|other| !Arc::ptr_eq(other, self));
        let mine = Arc::as_ptr(self).cast_mut();
        for place in &INSTANCES {
            // Pairs with `instances`.
            let order = (Ordering::SeqCst, Ordering::Relaxed);
            if place.compare_exchange(mine, null_mut(), order.0, order.1).is_ok() {
                wait_if_claimed();
                have_told();
                // SAFETY: made by `attend`; no thread can reach it any more.
                drop(unsafe { Arc::from_raw(mine) });
            }
        }
    }

    /// Replaces the list of what is loaded.
    pub(crate) fn replace(&self, remains: Remains) {
        let new = Box::into_raw(Box::new(remains));
        // Pairs with `remains`.
        let old = self.remains.swap(new, Ordering::SeqCst);
        wait_if_claimed();
        if !old.is_null() {
            // SAFETY: made by `Box::into_raw` here; no thread can reach it any more.
            drop(unsafe { Box::from_raw(old) });
        }
    }

    /// Returns what is loaded. Only the thread that has claimed the termination may call this.
    fn remains(&self) -> Option<&Remains> {
        // Pairs with the swap in `replace`.
        // SAFETY: `replace` frees the previous list only while no thread has claimed the
        // termination.
        unsafe { self.remains.load(Ordering::SeqCst).as_ref() }
    }

    /// Prevents further cycles from beginning.
    fn stop_cycles(&self) {
        self.shared.boundary.stop();
    }

    fn saved(&self) -> MutexGuard<'_, Saved> {
        self.saved.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the current recording.
    pub(crate) fn set_tape(&self, tape: Option<Arc<Mutex<Tape>>>) {
        self.saved().tape = tape;
    }

    /// Sets the current flight recorder.
    pub(crate) fn set_flight(&self, flight: Option<Arc<Mutex<Flight>>>) {
        self.saved().flight = flight;
    }

    /// Sets the list of running programs.
    pub(crate) fn set_programs(&self, programs: Vec<i32>) {
        board::set_programs(&programs);
        self.saved().programs = programs;
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let last = *self.remains.get_mut();
        if !last.is_null() {
            // SAFETY: made by `replace`; this was the last reference to it.
            drop(unsafe { Box::from_raw(last) });
        }
    }
}

fn all_known() -> MutexGuard<'static, Vec<Arc<Instance>>> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns every registered instance, for a thread that has not claimed the termination. Each lives
/// as long as the result holds it.
fn known() -> Vec<Arc<Instance>> {
    all_known().clone()
}

/// Iterates over every registered instance, for the thread that has claimed the termination.
fn instances() -> impl Iterator<Item = &'static Instance> {
    // Pairs with the exchanges in `attend` and `leave`.
    // SAFETY: `leave` frees an instance only while no thread has claimed the termination.
    INSTANCES.iter().filter_map(|place| unsafe { place.load(Ordering::SeqCst).as_ref() })
}

/// Blocks for good if the termination has been claimed: the thread that ends the process may still
/// read what was just unpublished.
fn wait_if_claimed() {
    if is_claimed() {
        park();
    }
}

/// Returns whether this process is the one whose termination is handled, and not a copy that a
/// component forked.
fn is_ours() -> bool {
    let ours = OURS.load(Ordering::Relaxed);
    ours != 0 && ours == sys::process()
}

/// Asks the control side to return from what it is doing.
fn want() {
    WANTED.store(true, Ordering::Relaxed);
    sys::wake(WAKE.load(Ordering::Relaxed));
}

/// Realtime. Returns whether the control side must return from what it is doing.
#[inline]
pub(crate) fn is_wanted() -> bool {
    WANTED.load(Ordering::Relaxed)
}

/// Returns whether a signal has asked this process to end.
pub(crate) fn is_asked() -> bool {
    signals::asked().is_some()
}

/// Returns the descriptor that becomes readable when the control side must return from what it is
/// doing, if there is one.
pub(crate) fn wake() -> Option<std::os::fd::BorrowedFd<'static>> {
    let fd = WAKE.load(Ordering::Relaxed);
    // SAFETY: it is never closed.
    (fd >= 0).then(|| unsafe { std::os::fd::BorrowedFd::borrow_raw(fd) })
}

/// Notes that the watcher need not report the end of this process.
fn have_told() {
    if let Some(board) = board::board() {
        board.untold.store(0, Ordering::Relaxed);
    }
}

/// Removes the files of all instances and restores the terminal.
fn leave_nothing() {
    instances().flat_map(|i| &i.files).for_each(|file| sys::remove(file));
    terminal::restore();
}

/// Adds a line to the text that the watcher reads.
fn note(line: core::fmt::Arguments<'_>) {
    if let Some(board) = board::board() {
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
        log.into_iter().for_each(|log| note(format_args!("l 0 {}", log.display())));
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
        have_told();
        OURS.store(0, Ordering::Relaxed);
        signals::unwatch();
    }
}

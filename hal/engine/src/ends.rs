//! How a process ends that is an instance: by a signal, a crash, or a function of a component that
//! ends it. Whatever it is, outputs go to their safe levels, who it was is said, what was seen is
//! kept, and no socket is left.
//!
//! [`Ends`] begins it. `signals.rs` attends to signals and `exits.rs` to the C library's functions;
//! both lead to `crash.rs`. The thread of `guard.rs` does what a signal handler must not, and ends
//! the process when the control side does not come back.

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
pub(crate) use board::{Current, NOBODY, record};
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

/// The process whose end is attended to, by its number: not a copy that a component makes of it.
static OURS: AtomicI32 = AtomicI32::new(0);
/// The guard's thread of the system; 0: none.
static GUARD: AtomicI32 = AtomicI32::new(0);
/// Whether the control side is to come back from what it does.
static WANTED: AtomicBool = AtomicBool::new(false);
/// What becomes readable then; -1: nothing.
static WAKE: AtomicI32 = AtomicI32::new(-1);
/// The instances of this process, for threads that may wait.
static KNOWN: Mutex<Vec<Arc<Instance>>> = Mutex::new(Vec::new());
/// The same for the thread that has claimed the end of the process: one, but for tests.
static INSTANCES: [AtomicPtr<Instance>; 32] = [const { AtomicPtr::new(null_mut()) }; 32];

/// What is known of an instance when its process ends.
#[derive(Debug)]
pub(crate) struct Instance {
    name: Box<str>,
    shared: Arc<Shared>,
    /// Its socket and its lock.
    files: Vec<CString>,
    /// The control side's thread of the system.
    thread: AtomicI32,
    pub(crate) control: Control,
    remains: AtomicPtr<Remains>,
    saved: Mutex<Saved>,
}

/// What is loaded.
#[derive(Debug, Default)]
pub(crate) struct Remains {
    /// Every stop action.
    pub(crate) stops: Vec<Arc<Code<CommandRun>>>,
    /// Where components come from.
    pub(crate) origins: Vec<Origin>,
    /// Components by their numbers.
    pub(crate) names: Vec<(u32, Name)>,
}

/// What is kept when the process ends.
#[derive(Debug, Default)]
struct Saved {
    tape: Option<Arc<Mutex<Tape>>>,
    flight: Option<Arc<Mutex<Flight>>>,
    /// Programs that the instance has started.
    programs: Vec<i32>,
}

impl Instance {
    /// One that is not attended to yet.
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

    /// Attends to it from now on: it has its socket.
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
        // SAFETY: made above, and nobody has seen it.
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

    /// Attends to it no more.
    pub(crate) fn leave(self: &Arc<Self>) {
        all_known().retain(|other| !Arc::ptr_eq(other, self));
        let mine = Arc::as_ptr(self).cast_mut();
        for place in &INSTANCES {
            // Pairs with `instances`.
            let order = (Ordering::SeqCst, Ordering::Relaxed);
            if place.compare_exchange(mine, null_mut(), order.0, order.1).is_ok() {
                wait_if_claimed();
                have_told();
                // SAFETY: made by `attend`; nobody looks at it any more.
                drop(unsafe { Arc::from_raw(mine) });
            }
        }
    }

    /// What is loaded is this now.
    pub(crate) fn replace(&self, remains: Remains) {
        let new = Box::into_raw(Box::new(remains));
        // Pairs with `remains`.
        let old = self.remains.swap(new, Ordering::SeqCst);
        wait_if_claimed();
        if !old.is_null() {
            // SAFETY: made by `Box::into_raw` here, and out of everybody's reach.
            drop(unsafe { Box::from_raw(old) });
        }
    }

    /// What is loaded; for the thread that has claimed the end of the process.
    fn remains(&self) -> Option<&Remains> {
        // SAFETY: what was replaced is freed only while nobody has claimed that: see `replace`.
        unsafe { self.remains.load(Ordering::SeqCst).as_ref() }
    }

    /// No cycle begins any more.
    fn stop_cycles(&self) {
        self.shared.boundary.stop();
    }

    fn saved(&self) -> MutexGuard<'_, Saved> {
        self.saved.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The recording is this one now.
    pub(crate) fn set_tape(&self, tape: Option<Arc<Mutex<Tape>>>) {
        self.saved().tape = tape;
    }

    /// The flight recorder is this one now.
    pub(crate) fn set_flight(&self, flight: Option<Arc<Mutex<Flight>>>) {
        self.saved().flight = flight;
    }

    /// The programs are these now.
    pub(crate) fn set_programs(&self, programs: Vec<i32>) {
        board::set_programs(&programs);
        self.saved().programs = programs;
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let last = *self.remains.get_mut();
        if !last.is_null() {
            // SAFETY: made by `replace`; this was the last who knew it.
            drop(unsafe { Box::from_raw(last) });
        }
    }
}

fn all_known() -> MutexGuard<'static, Vec<Arc<Instance>>> {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Every instance that is attended to, for a thread that has not claimed the end: each lives as
/// long as it is held.
fn known() -> Vec<Arc<Instance>> {
    all_known().clone()
}

/// Every instance that is attended to, for the thread that has claimed the end.
fn instances() -> impl Iterator<Item = &'static Instance> {
    // SAFETY: what has left is freed only while nobody has claimed the end: see `leave`.
    INSTANCES.iter().filter_map(|place| unsafe { place.load(Ordering::SeqCst).as_ref() })
}

/// What was taken out of reach may still be looked at by the thread that ends the process.
fn wait_if_claimed() {
    if is_claimed() {
        park();
    }
}

/// Whether this process is the one whose end is attended to.
fn is_ours() -> bool {
    let ours = OURS.load(Ordering::Relaxed);
    ours != 0 && ours == sys::process()
}

/// The control side is to come back.
fn want() {
    WANTED.store(true, Ordering::Relaxed);
    sys::wake(WAKE.load(Ordering::Relaxed));
}

/// Realtime. Whether the control side is to come back from what it does.
#[inline]
pub(crate) fn is_wanted() -> bool {
    WANTED.load(Ordering::Relaxed)
}

/// Whether a signal has asked this process to end.
pub(crate) fn is_asked() -> bool {
    signals::asked().is_some()
}

/// What becomes readable when the control side is to come back, if anything does.
pub(crate) fn wake() -> Option<std::os::fd::BorrowedFd<'static>> {
    let fd = WAKE.load(Ordering::Relaxed);
    // SAFETY: it is never closed.
    (fd >= 0).then(|| unsafe { std::os::fd::BorrowedFd::borrow_raw(fd) })
}

/// How this process ends has been said, or goes without saying.
fn have_told() {
    if let Some(board) = board::board() {
        board.untold.store(0, Ordering::Relaxed);
    }
}

/// Nothing of the instances is left in their folders, and the terminal is as it was found.
fn leave_nothing() {
    instances().flat_map(|i| &i.files).for_each(|file| sys::remove(file));
    terminal::restore();
}

/// Adds a line to what the watcher knows.
fn note(line: core::fmt::Arguments<'_>) {
    if let Some(board) = board::board() {
        board.add(&line.to_string());
    }
}

/// A function of a component is known by this number.
pub(crate) fn note_funct(number: u32, component: &Name, funct: &Name) {
    note(format_args!("f {number} component '{component}', function '{funct}'"));
}

/// A component has begun threads of its own, or has gone with them.
pub(crate) fn note_own_threads(component: &Name, there: bool) {
    note(format_args!("o {} {component}", i32::from(there)));
}

/// A recording goes to this file.
pub(crate) fn note_recording(path: &str, inode: u64) {
    let here = std::env::current_dir().unwrap_or_default().join(path);
    note(format_args!("r {inode} {}", here.display()));
}

/// The end of this process is attended to while this lives.
#[derive(Debug)]
pub struct Ends {
    #[expect(dead_code, reason = "the main thread attends to crashes on it")]
    stack: Stack,
    watcher: Option<Watcher>,
}

impl Ends {
    /// Begins to attend. For a program that is one instance and nothing else; from its main thread,
    /// before there is another one.
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

    /// The instance has ended in good order. Returns with the status that the process is to have,
    /// unless a signal has asked for its end that nobody means an instance by: then that ends it.
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

    /// Whoever waits for the end of what this process prints waits no more.
    /// From now on the watcher prints to the file `log`.
    pub fn be_quiet(&self, log: Option<&std::path::Path>) {
        log.into_iter().for_each(|log| note(format_args!("l 0 {}", log.display())));
        self.watcher.iter().for_each(Watcher::be_quiet);
    }

    /// What there is to say of the signal that has asked this process to end, if nobody means an
    /// instance by it.
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

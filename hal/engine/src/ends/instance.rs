//! Data of each instance of this process that is needed when the process ends.

use super::{
    board,
    doing::{Control, Origin},
    notes,
    process::{is_claimed, park},
    sys,
};
use crate::{
    load::code::Code,
    name::Name,
    observe::flight::Flight,
    observe::record::Tape,
    realtime::shared::Shared,
    sync::{Arc, AtomicI32, AtomicPtr, Ordering},
};
use core::ptr::null_mut;
use hal_abi::CommandRun;
use hal_protocol::Place;
use std::{
    ffi::CString,
    os::unix::ffi::OsStrExt,
    sync::{Mutex, MutexGuard, PoisonError},
};

/// The instances of this process, for threads that may wait.
static KNOWN: Mutex<Vec<Arc<Instance>>> = Mutex::new(Vec::new());
/// The instances of this process, for the thread that has claimed the termination. Only tests have
/// more than one.
static INSTANCES: [AtomicPtr<Instance>; 32] = [const { AtomicPtr::new(null_mut()) }; 32];

/// Data of an instance that is needed when its process ends.
#[derive(Debug)]
pub(crate) struct Instance {
    name: Box<str>,
    pub(super) shared: Arc<Shared>,
    /// Paths of its socket and of its lock file.
    pub(super) files: Vec<CString>,
    /// Thread ID of the control side.
    pub(super) thread: AtomicI32,
    pub(crate) control: Control,
    remains: AtomicPtr<Remains>,
    pub(super) saved: Mutex<Saved>,
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
pub(super) struct Saved {
    pub(super) tape: Option<Arc<Mutex<Tape>>>,
    pub(super) flight: Option<Arc<Mutex<Flight>>>,
    /// Programs that the instance has started.
    pub(super) programs: Vec<i32>,
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
        notes::note(format_args!("i 0 {}", self.name));
        for file in &self.files {
            notes::note(format_args!("s 0 {}", file.to_string_lossy()));
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
                notes::have_told();
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
    pub(super) fn remains(&self) -> Option<&Remains> {
        // Pairs with the swap in `replace`.
        // SAFETY: `replace` frees the previous list only while no thread has claimed the
        // termination.
        unsafe { self.remains.load(Ordering::SeqCst).as_ref() }
    }

    /// Prevents further cycles from beginning.
    pub(super) fn stop_cycles(&self) {
        self.shared.boundary.stop();
    }

    pub(super) fn saved(&self) -> MutexGuard<'_, Saved> {
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
pub(super) fn known() -> Vec<Arc<Instance>> {
    all_known().clone()
}

/// Iterates over every registered instance, for the thread that has claimed the termination.
pub(super) fn instances() -> impl Iterator<Item = &'static Instance> {
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

//! Realtime. Delivery of a change to running threads: as a whole, at a boundary between cycles.
//!
//! Each thread has a [`Gate`], which is shut while the thread is inside a cycle. The control side
//! offers one change at a time to the [`Boundary`]. The fastest thread takes the change before one
//! of its own cycles, when every other gate is open, and carries it out while the other threads are
//! held outside.

use crate::sync::{AtomicBool, AtomicPtr, Ordering, fence, relax};
use core::ptr::null_mut;

/// A flag that is set while one thread is inside a cycle.
#[derive(Debug)]
pub(crate) struct Gate {
    inside: AtomicBool,
}

impl Gate {
    /// Creates an open gate.
    pub(crate) fn new() -> Self {
        Self { inside: AtomicBool::new(false) }
    }

    /// Ends a cycle.
    pub(crate) fn leave(&self) {
        // Pairs with `is_inside`: a side that finds the gate open sees the effects of the cycle.
        self.inside.store(false, Ordering::Release);
    }

    /// Returns whether the thread is inside a cycle.
    pub(crate) fn is_inside(&self) -> bool {
        self.inside.load(Ordering::Acquire) // Pairs with `leave`.
    }
}

/// The meeting point of the control side and the threads of an instance.
#[derive(Debug)]
pub(crate) struct Boundary<C> {
    running: AtomicBool,
    editing: AtomicBool,
    offered: AtomicPtr<C>,
    taken: AtomicBool,
}

impl<C> Boundary<C> {
    /// Creates a boundary with stopped threads and no offer.
    pub(crate) fn new() -> Self {
        Self {
            running: AtomicBool::new(false),
            editing: AtomicBool::new(false),
            offered: AtomicPtr::new(null_mut()),
            taken: AtomicBool::new(false),
        }
    }

    /// Begins a cycle. Returns false if threads are stopped; the cycle must then not run.
    pub(crate) fn enter(&self, gate: &Gate) -> bool {
        loop {
            gate.inside.store(true, Ordering::Relaxed);
            // Pairs with the fences of `take` and `stop`: either they see this gate shut, or this
            // thread sees that they are editing or stopping.
            fence(Ordering::SeqCst);
            // Pairs with the end of `take`: the effects of the change are visible.
            if !self.editing.load(Ordering::Acquire) {
                break;
            }
            gate.leave();
            while self.editing.load(Ordering::Relaxed) {
                relax();
            }
        }
        // Pairs with `start`: the control side's preparations are visible.
        if self.running.load(Ordering::Acquire) {
            return true;
        }
        gate.leave();
        false
    }

    /// Called by the fastest thread outside its own cycle: carries out the offered change, if there
    /// is one. Returns whether it did. `others_inside` returns whether any other thread is inside a
    /// cycle; it checks the threads that exist when it is called, which include any thread added
    /// before.
    pub(crate) fn take(
        &self,
        others_inside: impl FnOnce() -> bool,
        apply: impl FnOnce(&C),
    ) -> bool {
        if self.offered.load(Ordering::Relaxed).is_null() {
            return false;
        }
        self.editing.store(true, Ordering::Relaxed);
        fence(Ordering::SeqCst); // Pairs with the fence of `enter`.
        if others_inside() {
            self.editing.store(false, Ordering::Release); // Pairs with `enter`.
            return false;
        }
        // Pairs with `offer` (contents of the change) and `withdraw` (only one side gets it).
        let change = self.offered.swap(null_mut(), Ordering::AcqRel);
        // SAFETY: the control side keeps an offered change alive until it is taken or withdrawn.
        let done = unsafe { change.as_ref() }.map(apply).is_some();
        if done {
            self.taken.store(true, Ordering::Release); // Pairs with `is_taken`.
        }
        self.editing.store(false, Ordering::Release); // Pairs with `enter`.
        done
    }

    /// Control side: offers a change; it must live until [`Self::is_taken`] or [`Self::withdraw`]
    /// has returned true.
    pub(crate) fn offer(&self, change: &C) {
        self.taken.store(false, Ordering::Relaxed);
        // Pairs with `take`.
        self.offered.store(core::ptr::from_ref(change).cast_mut(), Ordering::Release);
    }

    /// Control side: returns whether the offered change has been carried out.
    pub(crate) fn is_taken(&self) -> bool {
        self.taken.load(Ordering::Acquire) // Pairs with `take`.
    }

    /// Control side: withdraws an offer. Returns false if a thread has it already; that thread will
    /// carry it out.
    pub(crate) fn withdraw(&self) -> bool {
        !self.offered.swap(null_mut(), Ordering::AcqRel).is_null() // Pairs with `take`.
    }

    /// Control side: lets threads run their functions from their next cycle on.
    pub(crate) fn start(&self) {
        self.running.store(true, Ordering::Release); // Pairs with `enter`.
    }

    /// Control side: prevents any further cycle. A cycle may still be in progress: see
    /// [`Gate::is_inside`].
    pub(crate) fn stop(&self) {
        self.running.store(false, Ordering::Relaxed);
        fence(Ordering::SeqCst); // Pairs with the fence of `enter`.
    }

    /// Returns whether threads run their functions.
    pub(crate) fn is_running(&self) -> bool {
        self.running.load(Ordering::Relaxed)
    }
}

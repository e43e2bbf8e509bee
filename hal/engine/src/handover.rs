//! Realtime. How a change reaches running threads: whole, at a boundary between cycles.
//!
//! Each thread has a [`Gate`]: shut while it is inside a cycle. The control side offers one
//! change at a time to the [`Boundary`]; the fastest thread takes it before a cycle of its own,
//! when every other gate is open, and carries it out while the others are held outside.

use crate::sync::{AtomicBool, AtomicPtr, Ordering, fence, relax};
use core::ptr::null_mut;

/// Whether one thread is inside a cycle.
#[derive(Debug)]
pub(crate) struct Gate {
    inside: AtomicBool,
}

impl Gate {
    /// An open gate.
    pub(crate) fn new() -> Self {
        Self { inside: AtomicBool::new(false) }
    }

    /// Ends a cycle.
    pub(crate) fn leave(&self) {
        // Pairs with `is_inside`: what the cycle did is seen by whoever finds the gate open.
        self.inside.store(false, Ordering::Release);
    }

    /// Whether the thread is inside a cycle.
    pub(crate) fn is_inside(&self) -> bool {
        self.inside.load(Ordering::Acquire) // Pairs with `leave`.
    }
}

/// Where the control side and the threads of an instance meet.
#[derive(Debug)]
pub(crate) struct Boundary<C> {
    running: AtomicBool,
    editing: AtomicBool,
    offered: AtomicPtr<C>,
    taken: AtomicBool,
}

impl<C> Boundary<C> {
    /// Threads stopped, nothing offered.
    pub(crate) fn new() -> Self {
        Self {
            running: AtomicBool::new(false),
            editing: AtomicBool::new(false),
            offered: AtomicPtr::new(null_mut()),
            taken: AtomicBool::new(false),
        }
    }

    /// Begins a cycle: false when threads are stopped, and the cycle is then not run.
    pub(crate) fn enter(&self, gate: &Gate) -> bool {
        loop {
            gate.inside.store(true, Ordering::Relaxed);
            // Pairs with the fences of `take` and `stop`: either they see this gate shut, or this
            // sees them editing or stopping.
            fence(Ordering::SeqCst);
            // Pairs with the end of `take`: what was carried out is seen.
            if !self.editing.load(Ordering::Acquire) {
                break;
            }
            gate.leave();
            while self.editing.load(Ordering::Relaxed) {
                relax();
            }
        }
        // Pairs with `start`: what was prepared is seen.
        if self.running.load(Ordering::Acquire) {
            return true;
        }
        gate.leave();
        false
    }

    /// The fastest thread's chance to carry out what is offered, outside its own cycle. True when
    /// it did. `others_inside` says whether any other thread is inside a cycle; it looks at the
    /// threads that there are when it is called: one that was added before is then among them.
    pub(crate) fn take(
        &self,
        others_inside: impl FnOnce() -> bool,
        carry_out: impl FnOnce(&C),
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
        // Pairs with `offer` (its contents) and `withdraw` (who gets it).
        let change = self.offered.swap(null_mut(), Ordering::AcqRel);
        // SAFETY: the control side keeps an offered change alive until it is taken or withdrawn.
        let done = unsafe { change.as_ref() }.map(carry_out).is_some();
        if done {
            self.taken.store(true, Ordering::Release); // Pairs with `is_taken`.
        }
        self.editing.store(false, Ordering::Release); // Pairs with `enter`.
        done
    }

    /// Control side: offers a change; it must live until [`Self::is_taken`] or
    /// [`Self::withdraw`] has said yes.
    pub(crate) fn offer(&self, change: &C) {
        self.taken.store(false, Ordering::Relaxed);
        // Pairs with `take`.
        self.offered.store(core::ptr::from_ref(change).cast_mut(), Ordering::Release);
    }

    /// Control side: whether what was offered has been carried out.
    pub(crate) fn is_taken(&self) -> bool {
        self.taken.load(Ordering::Acquire) // Pairs with `take`.
    }

    /// Control side: takes an offer back. False when a thread has it already: it will be taken.
    pub(crate) fn withdraw(&self) -> bool {
        !self.offered.swap(null_mut(), Ordering::AcqRel).is_null() // Pairs with `take`.
    }

    /// Control side: threads run their functions from their next cycle on.
    pub(crate) fn start(&self) {
        self.running.store(true, Ordering::Release); // Pairs with `enter`.
    }

    /// Control side: no further cycle begins. A cycle may still be under way: see
    /// [`Gate::is_inside`].
    pub(crate) fn stop(&self) {
        self.running.store(false, Ordering::Relaxed);
        fence(Ordering::SeqCst); // Pairs with the fence of `enter`.
    }

    /// Whether threads run their functions.
    pub(crate) fn is_running(&self) -> bool {
        self.running.load(Ordering::Relaxed)
    }
}

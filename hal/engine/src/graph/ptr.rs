//! Pointers to slots and cells of the arena.

use crate::sync::AtomicPtr;
use core::ptr::NonNull;
use hal_abi::{Cell, Slot};

/// A pointer that the binary interface lets other threads use.
#[derive(Debug)]
pub(crate) struct Ptr<T>(pub(crate) NonNull<T>);
impl<T> Clone for Ptr<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Ptr<T> {}
impl<T> PartialEq for Ptr<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}
// SAFETY: only for slots and cells, which are atomic and live in the arena.
unsafe impl<T> Send for Ptr<T> {}
// SAFETY: as for `Send`.
unsafe impl<T> Sync for Ptr<T> {}

/// A pointer of foreign code that follows a pin.
pub(crate) type Pointer = Ptr<AtomicPtr<Cell>>;

/// Returns a slot's own cell, which holds the value of a parameter.
pub(crate) fn own_cell(slot: Ptr<Slot>) -> Ptr<Cell> {
    // SAFETY: the slot is a live slot of the arena.
    Ptr(NonNull::from(unsafe { slot.0.as_ref() }.own()))
}

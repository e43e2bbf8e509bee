//! Realtime. A change to the graph: a list of stores that is carried out as a whole.

use crate::{
    graph::own,
    graph::ptr::Pointer,
    graph::ptr::Ptr,
    graph::ptr::own_cell,
    realtime::thread::{List, Thread},
    sync::{Arc, Ordering},
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{Cell, Slot};
use hal_protocol::Type;

/// Largest number of stores that are carried out at once while threads run.
pub(crate) const MAX_STORES: usize = 256;

/// A single store.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Store {
    /// Puts a value into a cell.
    Put {
        /// The cell.
        cell: Ptr<Cell>,
        /// The value, as the bits of its type.
        bits: u64,
    },
    /// Puts a value into a component's own memory, at the width of its type.
    PutOwn {
        /// Address in the component's memory.
        place: Ptr<c_void>,
        /// Type of the value there.
        ty: Type,
        /// The value, as the bits of its type.
        bits: u64,
    },
    /// Copies a pin's own value into its future signal.
    CopyIn {
        /// The slot whose own cell is read.
        slot: Ptr<Slot>,
        /// The cell that is written.
        cell: Ptr<Cell>,
    },
    /// Copies a signal's value into a pin's own cell.
    CopyOut {
        /// The cell that is read.
        cell: Ptr<Cell>,
        /// The slot whose own cell is written.
        slot: Ptr<Slot>,
    },
    /// Updates the pointer through which foreign code reaches its pin's value.
    SetForeign {
        /// The pointer in the component's memory.
        pointer: Pointer,
        /// The pin's new cell.
        cell: Ptr<Cell>,
    },
    /// Points a pin at another cell.
    Relink {
        /// The pin's slot.
        slot: Ptr<Slot>,
        /// Distance from the slot to its new cell.
        distance: i32,
    },
}

impl Store {
    /// Returns the stores that point a pin at the cell at this distance from its slot, and foreign
    /// code's pointer with it.
    pub(crate) fn aimed(
        slot: NonNull<Slot>,
        distance: i32,
        pointer: Option<Pointer>,
        cell: Ptr<Cell>,
    ) -> impl Iterator<Item = Self> {
        let aim = Self::Relink { slot: Ptr(slot), distance };
        let point = pointer.map(|pointer| Self::SetForeign { pointer, cell });
        [Some(aim), point].into_iter().flatten()
    }
}

/// Updates the pointer through which foreign code reaches its pin's value.
pub(crate) fn point(pointer: Pointer, cell: Ptr<Cell>) {
    // SAFETY: in memory of the component, which lives as long as the pin.
    let pointer = unsafe { pointer.0.as_ref() };
    pointer.store(cell.0.as_ptr(), Ordering::Release); // Pairs with each use by foreign code.
}

/// A change: stores, then new function lists.
#[derive(Debug, Default)]
pub(crate) struct Change {
    pub(crate) stores: Vec<Store>,
    pub(crate) lists: Vec<(Arc<Thread>, Arc<List>)>,
}

impl Store {
    /// Carries out the store.
    pub(crate) fn apply(&self) {
        match *self {
            Self::Put { cell, bits } => {
                // SAFETY: a live cell of the arena.
                unsafe { cell.0.as_ref() }.store(bits);
            }
            Self::PutOwn { place, ty, bits } => own::store(place.0, ty, bits),
            Self::CopyIn { slot, cell } => {
                // SAFETY: a live slot of the arena.
                let bits = unsafe { slot.0.as_ref() }.own().load();
                // SAFETY: a live cell of the arena.
                unsafe { cell.0.as_ref() }.store(bits);
            }
            Self::CopyOut { cell, slot } => {
                // SAFETY: a live cell of the arena.
                let bits = unsafe { cell.0.as_ref() }.load();
                // SAFETY: a live slot of the arena.
                unsafe { slot.0.as_ref() }.own().store(bits);
            }
            Self::SetForeign { pointer, cell } => point(pointer, cell),
            Self::Relink { slot, distance } => {
                // SAFETY: a live slot of the arena.
                unsafe { slot.0.as_ref() }.aim(distance);
            }
        }
    }

    /// Returns the addresses that the store reads or writes.
    pub(crate) fn places(&self) -> [usize; 2] {
        let at = |p: Ptr<Cell>| p.0.addr().get();
        match *self {
            Self::Put { cell, .. } => [at(cell); 2],
            Self::PutOwn { place, .. } => [place.0.addr().get(); 2],
            Self::CopyIn { slot, cell } | Self::CopyOut { cell, slot } => {
                [at(own_cell(slot)), at(cell)]
            }
            Self::SetForeign { pointer, .. } => [pointer.0.addr().get(); 2],
            Self::Relink { slot, .. } => [slot.0.addr().get(); 2],
        }
    }
}

impl Change {
    /// Returns whether the change is one atomic store, which needs no boundary.
    pub(crate) fn is_atomic(&self) -> bool {
        let one = matches!(*self.stores, [Store::Put { .. } | Store::PutOwn { .. }]);
        one && self.lists.is_empty()
    }

    /// Carries out every store, then replaces the lists. Allocates and frees nothing: the caller
    /// keeps the old lists.
    pub(crate) fn apply(&self) {
        self.stores.iter().for_each(Store::apply);
        for (thread, list) in &self.lists {
            thread.list.store(list.clone());
        }
    }
}

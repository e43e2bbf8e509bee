//! Realtime. A change to the graph as a list of stores, carried out whole.

use crate::{
    code::Ptr,
    foreign::Pointer,
    item::own_cell,
    node::own,
    sync::{Arc, Ordering},
    thread::{List, Thread},
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{Cell, Slot};
use hal_protocol::Type;

/// The most stores that are made at once while threads run.
pub(crate) const MOST_STORES: usize = 256;

/// One store.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Store {
    /// Puts a value into a cell.
    Put {
        /// Where.
        cell: Ptr<Cell>,
        /// What.
        bits: u64,
    },
    /// Puts a value into a component's own memory, at the width of its type.
    PutOwn {
        /// Where.
        place: Ptr<c_void>,
        /// What is there.
        ty: Type,
        /// What.
        bits: u64,
    },
    /// Copies a pin's own value into its future signal.
    Bring {
        /// From this slot's own cell.
        slot: Ptr<Slot>,
        /// To this cell.
        cell: Ptr<Cell>,
    },
    /// Copies a signal's value into a pin's own cell.
    Keep {
        /// From this cell.
        cell: Ptr<Cell>,
        /// To this slot's own cell.
        slot: Ptr<Slot>,
    },
    /// Tells foreign code where its pin's value is.
    Point {
        /// Where it keeps that.
        pointer: Pointer,
        /// The pin's new cell.
        cell: Ptr<Cell>,
    },
    /// Aims a pin.
    Aim {
        /// The pin's slot.
        slot: Ptr<Slot>,
        /// The distance to its new cell.
        distance: i32,
    },
}

impl Store {
    /// What aims a pin at a cell so far from its slot, and foreign code with it.
    pub(crate) fn aimed(
        slot: NonNull<Slot>,
        distance: i32,
        pointer: Option<Pointer>,
        cell: Ptr<Cell>,
    ) -> impl Iterator<Item = Self> {
        let aim = Self::Aim { slot: Ptr(slot), distance };
        let point = pointer.map(|pointer| Self::Point { pointer, cell });
        [Some(aim), point].into_iter().flatten()
    }
}

/// Tells foreign code where its pin's value is.
pub(crate) fn point(pointer: Pointer, cell: Ptr<Cell>) {
    // SAFETY: in memory of the component, which lives as long as the pin.
    let pointer = unsafe { pointer.0.as_ref() };
    pointer.store(cell.0.as_ptr(), Ordering::Release); // Pairs with each use by foreign code.
}

/// A change: stores, then new lists of functions.
#[derive(Debug, Default)]
pub(crate) struct Change {
    pub(crate) stores: Vec<Store>,
    pub(crate) lists: Vec<(Arc<Thread>, Arc<List>)>,
}

impl Store {
    /// Makes it.
    pub(crate) fn carry_out(&self) {
        match *self {
            Self::Put { cell, bits } => {
                // SAFETY: a live cell of the arena.
                unsafe { cell.0.as_ref() }.store(bits);
            }
            Self::PutOwn { place, ty, bits } => own::store(place.0, ty, bits),
            Self::Bring { slot, cell } => {
                // SAFETY: a live slot of the arena.
                let bits = unsafe { slot.0.as_ref() }.own().load();
                // SAFETY: a live cell of the arena.
                unsafe { cell.0.as_ref() }.store(bits);
            }
            Self::Keep { cell, slot } => {
                // SAFETY: a live cell of the arena.
                let bits = unsafe { cell.0.as_ref() }.load();
                // SAFETY: a live slot of the arena.
                unsafe { slot.0.as_ref() }.own().store(bits);
            }
            Self::Point { pointer, cell } => point(pointer, cell),
            Self::Aim { slot, distance } => {
                // SAFETY: a live slot of the arena.
                unsafe { slot.0.as_ref() }.aim(distance);
            }
        }
    }

    /// What it reads or writes, by address.
    pub(crate) fn places(&self) -> [usize; 2] {
        let at = |p: Ptr<Cell>| p.0.addr().get();
        match *self {
            Self::Put { cell, .. } => [at(cell); 2],
            Self::PutOwn { place, .. } => [place.0.addr().get(); 2],
            Self::Bring { slot, cell } | Self::Keep { cell, slot } => {
                [at(own_cell(slot)), at(cell)]
            }
            Self::Point { pointer, .. } => [pointer.0.addr().get(); 2],
            Self::Aim { slot, .. } => [slot.0.addr().get(); 2],
        }
    }
}

impl Change {
    /// Whether it is one atomic store, which is whole by itself.
    pub(crate) fn is_atomic(&self) -> bool {
        let one = matches!(*self.stores, [Store::Put { .. } | Store::PutOwn { .. }]);
        one && self.lists.is_empty()
    }

    /// Makes every store. Allocates and frees nothing: the caller keeps the old lists.
    pub(crate) fn carry_out(&self) {
        self.stores.iter().for_each(Store::carry_out);
        for (thread, list) in &self.lists {
            thread.list.store(list.clone());
        }
    }
}

//! Realtime. A change to the graph as a list of stores, carried out whole.

use crate::{
    code::Ptr,
    sync::Arc,
    thread::{List, Thread},
};
use hal_abi::{Cell, Slot};

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
    /// Aims a pin.
    Aim {
        /// The pin's slot.
        slot: Ptr<Slot>,
        /// The distance to its new cell.
        distance: i32,
    },
}

/// A change: stores, then new lists of functions.
#[derive(Debug, Default)]
pub(crate) struct Change {
    pub(crate) stores: Vec<Store>,
    pub(crate) lists: Vec<(Arc<Thread>, Arc<List>)>,
}

impl Change {
    /// Makes every store. Allocates and frees nothing: the caller keeps the old lists.
    pub(crate) fn carry_out(&self) {
        for store in &self.stores {
            match *store {
                Store::Put { cell, bits } => {
                    // SAFETY: a live cell of the arena.
                    unsafe { cell.0.as_ref() }.store(bits);
                }
                Store::Bring { slot, cell } => {
                    // SAFETY: a live slot of the arena.
                    let bits = unsafe { slot.0.as_ref() }.own().load();
                    // SAFETY: a live cell of the arena.
                    unsafe { cell.0.as_ref() }.store(bits);
                }
                Store::Keep { cell, slot } => {
                    // SAFETY: a live cell of the arena.
                    let bits = unsafe { cell.0.as_ref() }.load();
                    // SAFETY: a live slot of the arena.
                    unsafe { slot.0.as_ref() }.own().store(bits);
                }
                Store::Aim { slot, distance } => {
                    // SAFETY: a live slot of the arena.
                    unsafe { slot.0.as_ref() }.aim(distance);
                }
            }
        }
        for (thread, list) in &self.lists {
            thread.list.store(list.clone());
        }
    }
}

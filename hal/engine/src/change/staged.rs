//! The staged effects of a transaction, and the log of its steps.

use crate::{
    change::stores::Store,
    change::undo::{Order, Undo},
    graph::Ix,
    graph::arena::Mark,
    graph::names::Index,
    graph::ptr::{Ptr, own_cell},
};
use hal_abi::Slot;
use hal_protocol::Lock;
use std::collections::{BTreeMap, BTreeSet};

/// A thing that is removed after the transaction has been carried out.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PendingRemoval {
    /// A signal that has lost its name.
    Signal(Ix),
    /// A component that has lost its name.
    Component {
        /// The component's node.
        ix: Ix,
        /// True if its stop actions run first.
        stop: bool,
    },
}

impl PendingRemoval {
    /// Returns the component, if it is one.
    pub(crate) const fn component(&self) -> Option<Ix> {
        match *self {
            Self::Component { ix, .. } => Some(ix),
            Self::Signal(_) => None,
        }
    }
}

/// Counters that a reverted transaction restores.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counters {
    /// Numbers of pins and parameters.
    pub(crate) pins: u32,
    pub(crate) params: u32,
    /// Numbers of the next component and the next thread.
    pub(crate) next_component: u32,
    pub(crate) next_thread: u32,
}

/// State that a reverted transaction simply restores.
#[derive(Debug)]
pub(crate) struct Before {
    pub(crate) counters: Counters,
    pub(crate) lock: Lock,
    pub(crate) mark: Mark,
}

/// The staged effects of a transaction.
#[derive(Debug, Default)]
pub(crate) struct Staged {
    dry: bool,
    stores: Vec<Store>,
    pending_removal: Vec<PendingRemoval>,
    new_threads: Vec<Ix>,
    ended_probes: BTreeSet<u64>,
    starts: bool,
    undo: Vec<Undo>,
    orders: BTreeMap<Ix, Order>,
    before: Option<Before>,
    /// Addresses of new slots and cells that threads see before the boundary.
    visible: BTreeSet<usize>,
    /// Addresses in the own memory of new components, which no thread uses yet.
    own: BTreeSet<usize>,
}

/// Steps of a request.
impl Staged {
    /// Begins a transaction; `before` is restored if it is reverted.
    pub(crate) fn new(before: Before) -> Self {
        Self { before: Some(before), ..Self::default() }
    }

    /// Makes the transaction a dry run: it is only checked, and nothing is opened or started.
    pub(crate) const fn only_check(&mut self) {
        self.dry = true;
    }

    /// Records how to revert a step.
    pub(crate) fn undo_by(&mut self, undo: Undo) {
        self.undo.push(undo);
    }

    /// Adds a store, after those of earlier requests.
    pub(crate) fn store(&mut self, store: Store) {
        self.stores.push(store);
    }

    /// Adds stores, after those of earlier requests.
    pub(crate) fn stores(&mut self, stores: impl IntoIterator<Item = Store>) {
        self.stores.extend(stores);
    }

    /// Removes a thing at the end of the transaction.
    pub(crate) fn remove(&mut self, removal: PendingRemoval) {
        self.pending_removal.push(removal);
    }

    /// Runs new threads from the end of the transaction on.
    pub(crate) fn begin_threads(&mut self, threads: Vec<Ix>) {
        self.new_threads.extend(threads);
    }

    /// Starts threads at the end, or does not.
    pub(crate) const fn start(&mut self, starts: bool) {
        self.starts = starts;
    }

    /// Ends a probe that watches something that is removed.
    pub(crate) fn end_probe(&mut self, probe: u64) {
        self.ended_probes.insert(probe);
    }

    /// Marks a new slot as visible, because its own thread writes it from the first cycle on.
    pub(crate) fn sees(&mut self, slot: Ptr<Slot>) {
        let cell = own_cell(slot);
        self.visible.extend([slot.0.addr().get(), cell.0.addr().get()]);
    }

    /// Marks an address in the own memory of a new component as used by no thread.
    pub(crate) fn owns(&mut self, address: usize) {
        self.own.insert(address);
    }

    /// Records the functions of a thread before the first change to them.
    pub(crate) fn note_order(&mut self, thread: Ix, end: impl FnOnce() -> Option<Order>) {
        if !self.orders.contains_key(&thread)
            && let Some(order) = end()
        {
            self.orders.insert(thread, order);
        }
    }

    /// Returns the record of a thread's functions.
    pub(crate) fn order_of(&mut self, thread: Ix) -> Option<&mut Order> {
        self.orders.get_mut(&thread)
    }
}

/// Questions of the commit.
impl Staged {
    /// Returns whether the transaction is only checked.
    pub(crate) const fn is_dry(&self) -> bool {
        self.dry
    }

    /// Returns whether threads are started at the end.
    pub(crate) const fn starts(&self) -> bool {
        self.starts
    }

    /// Returns whether new threads begin at the end.
    pub(crate) const fn has_new_threads(&self) -> bool {
        !self.new_threads.is_empty()
    }

    /// Returns whether something is removed at the end.
    pub(crate) const fn removes(&self) -> bool {
        !self.pending_removal.is_empty()
    }

    /// Returns whether this probe ends with the transaction.
    pub(crate) fn parts(&self, probe: u64) -> bool {
        self.ended_probes.contains(&probe)
    }

    /// Returns what is removed at the end.
    pub(crate) fn pending_removal(&self) -> &[PendingRemoval] {
        &self.pending_removal
    }

    /// Returns the threads whose functions change.
    pub(crate) fn changed_threads(&self) -> impl Iterator<Item = Ix> {
        self.orders.keys().copied()
    }

    /// Returns whether this transaction unloads a component of this name.
    pub(crate) fn unloads(&self, name: &str) -> bool {
        let unnamed =
            |u: &Undo| matches!(u, Undo::Unnamed(Index::Components, n, _) if n.as_str() == name);
        self.undo.iter().any(unnamed)
    }

    /// Returns whether anything but values has changed.
    pub(crate) fn changes_graph(&self) -> bool {
        self.undo.iter().any(|u| !matches!(u, Undo::Assigned(..)))
    }

    /// Returns whether a component was opened.
    pub(crate) fn opens(&self) -> bool {
        self.undo.iter().any(|u| matches!(u, Undo::Opened(_)))
    }

    /// Returns the state from before the transaction.
    pub(crate) const fn before(&self) -> Option<&Before> {
        self.before.as_ref()
    }

    /// Returns whether an address is new to all threads: it was `made` in this transaction and is
    /// not marked as visible, or it is in the own memory of a new component.
    pub(crate) fn is_unseen(&self, address: usize, made: bool) -> bool {
        made && !self.visible.contains(&address) || self.own.contains(&address)
    }

    /// Takes the stores, in the order of the requests.
    pub(crate) fn take_stores(&mut self) -> Vec<Store> {
        core::mem::take(&mut self.stores)
    }

    /// Takes the new threads.
    pub(crate) fn take_new_threads(&mut self) -> Vec<Ix> {
        core::mem::take(&mut self.new_threads)
    }

    /// Takes the probes that end.
    pub(crate) fn take_ended_probes(&mut self) -> BTreeSet<u64> {
        core::mem::take(&mut self.ended_probes)
    }

    /// Takes the things to be removed.
    pub(crate) fn take_pending_removal(&mut self) -> Vec<PendingRemoval> {
        core::mem::take(&mut self.pending_removal)
    }

    /// Takes the log: the steps, the functions of changed threads, and the state from before.
    pub(crate) fn into_log(self) -> (Vec<Undo>, BTreeMap<Ix, Order>, Option<Before>) {
        (self.undo, self.orders, self.before)
    }
}

/// Splits stores into those that touch only memory that no thread can see, and the rest. A
/// store that shares memory with an earlier store of the rest stays with the rest, after it.
pub(crate) fn split(
    stores: Vec<Store>,
    unseen: impl Fn(usize) -> bool,
) -> (Vec<Store>, Vec<Store>) {
    let mut shared = BTreeSet::new();
    stores.into_iter().partition(|store| {
        let places = store.places();
        let early = places.iter().all(|p| unseen(*p) && !shared.contains(p));
        if !early {
            shared.extend(places);
        }
        early
    })
}

#[cfg(test)]
mod tests {
    use super::split;
    use crate::{change::stores::Store, graph::arena::Arena, graph::ptr::Ptr};
    use std::collections::BTreeSet;

    #[test]
    fn stores_that_no_thread_sees_go_first_unless_they_follow_one_that_threads_see() {
        let mut arena = Arena::new(false).unwrap();
        let (shown, new) = (Ptr(arena.slot(0).unwrap()), Ptr(arena.slot(0).unwrap()));
        let (signal, other) = (Ptr(arena.cell(0).unwrap()), Ptr(arena.cell(0).unwrap()));
        let own = crate::graph::ptr::own_cell(new);
        let fresh = BTreeSet::from([new.0.addr().get(), own.0.addr().get(), other.0.addr().get()]);
        let stores = vec![
            Store::Put { cell: own, bits: 1 },
            Store::CopyIn { slot: new, cell: other },
            Store::CopyOut { cell: signal, slot: shown },
            Store::Put { cell: other, bits: 2 },
            Store::CopyIn { slot: new, cell: signal },
            Store::Put { cell: own, bits: 3 },
            Store::Relink { slot: new, distance: 8 },
            Store::Put { cell: other, bits: 4 },
        ];
        let (early, late) = split(stores, |place| fresh.contains(&place));
        let shown: Vec<String> = early.iter().chain(&late).map(|s| format!("{s:?}")).collect();
        let begins = |i: usize, what: &str| assert!(shown[i].starts_with(what), "{shown:#?}");
        assert_eq!((early.len(), late.len()), (5, 3), "{shown:#?}");
        for (i, what) in
            ["Put", "CopyIn", "Put", "Relink", "Put", "CopyOut", "CopyIn", "Put"].iter().enumerate()
        {
            begins(i, what);
        }
    }
}

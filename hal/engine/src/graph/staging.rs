//! Staged steps: how each is recorded, and how it is reverted.

use crate::{
    Error,
    change::staged::{Before, Staged, split},
    change::stores::{Change, MAX_STORES, Store},
    change::undo::{Order, Undo},
    graph::model::Model,
    graph::names::Index,
    graph::sites::Site,
    graph::{Edge, Graph, Ix},
    name::Name,
};
use petgraph::{Direction::Outgoing, stable_graph::EdgeIndex, visit::EdgeRef};
use std::collections::{BTreeMap, BTreeSet};

impl Graph {
    /// Returns the state of a thread without its functions, before functions are added at its end.
    pub(crate) fn end_of(&self, thread: Ix) -> Option<Order> {
        let node = self.thread(thread)?;
        Some(Order { functs: None, next: node.next, stale: node.stale })
    }

    /// Records the functions that a thread runs now, without those added since `order` was taken.
    pub(crate) fn note_order(&self, thread: Ix, order: &mut Order) {
        if order.functs.is_none() {
            let runs = self.g.edges_directed(thread, Outgoing);
            let runs = runs.filter(|e| e.weight().place().is_some_and(|at| at <= order.next));
            let functs = runs.map(|e| (e.target(), *e.weight(), self.sites.of_joined(e.id())));
            order.functs = Some(functs.collect());
        }
    }

    /// Removes every function from a thread.
    pub(crate) fn empty_thread(&mut self, thread: Ix) {
        self.shorten_thread(thread, 0);
    }

    /// Removes the functions of a thread whose place is beyond `last`.
    fn shorten_thread(&mut self, thread: Ix, last: u32) {
        let runs = self.g.edges_directed(thread, Outgoing);
        let runs = runs.filter(|e| e.weight().place().is_some_and(|at| at > last));
        let edges: Vec<_> = runs.map(|e| e.id()).collect();
        for edge in edges {
            self.g.remove_edge(edge);
            self.sites.parted(edge);
        }
    }

    /// Restores the functions of a thread that is empty, or that only has more at its end.
    fn refill_thread(&mut self, thread: Ix, order: &Order) {
        match &order.functs {
            None => self.shorten_thread(thread, order.next),
            // Walking edges yields the latest first.
            Some(functs) => {
                for (funct, runs, site) in functs.iter().rev() {
                    let edge = self.g.add_edge(thread, *funct, *runs);
                    self.sites.joined_at(edge, *site);
                }
            }
        }
        if let Some(node) = self.thread_mut(thread) {
            node.next = order.next;
            node.stale = order.stale;
        }
    }

    /// Adds the link of a pin, and counts it on the signal.
    pub(crate) fn draw_link(&mut self, pin: Ix, signal: Ix) -> EdgeIndex<u32> {
        let edge = self.g.add_edge(pin, signal, Edge::Links);
        let direction = self.item(pin).map(|p| p.direction);
        if let (Some(d), Some(s)) = (direction, self.signal_mut(signal)) {
            s.count(d, true);
        }
        edge
    }

    /// Removes the link of a pin. Returns the signal that it was linked to, and the script position
    /// of the link.
    pub(crate) fn remove_link(&mut self, pin: Ix) -> Option<(Ix, Option<Site>)> {
        let mut links = self.g.edges_directed(pin, Outgoing);
        let link = links.find(|e| *e.weight() == Edge::Links);
        let (edge, signal) = link.map(|e| (e.id(), e.target()))?;
        let site = self.sites.of_joined(edge);
        self.g.remove_edge(edge);
        self.sites.parted(edge);
        let direction = self.item(pin).map(|p| p.direction);
        if let (Some(d), Some(s)) = (direction, self.signal_mut(signal)) {
            s.count(d, false);
        }
        Some((signal, site))
    }
}

impl Model {
    /// Begins a transaction.
    pub(crate) fn begin(&mut self) {
        let (counters, lock, mark) = (self.counters, self.lock, self.arena.mark());
        self.staged = Staged::new(Before { counters, lock, mark });
    }

    /// Gives a node a name.
    pub(crate) fn name_node(&mut self, index: Index, name: Name, ix: Ix) {
        self.graph.add_name(index, &name, ix);
        self.staged.undo_by(Undo::Named(index, name, ix));
    }

    /// Removes a node's name, if the name belongs to the node.
    pub(crate) fn unname(&mut self, index: Index, name: &Name, ix: Ix) {
        if self.graph.remove_name(index, name, ix) {
            self.staged.undo_by(Undo::Unnamed(index, name.clone(), ix));
        }
    }

    /// Records the functions of a thread before they change.
    pub(crate) fn touch_thread(&mut self, thread: Ix) {
        self.extend_thread(thread);
        if let Some(order) = self.staged.order_of(thread) {
            self.graph.note_order(thread, order);
        }
    }

    /// Records the end of a thread before a function is added there.
    pub(crate) fn extend_thread(&mut self, thread: Ix) {
        self.staged.note_order(thread, || self.graph.end_of(thread));
        if let Some(node) = self.graph.thread_mut(thread) {
            node.stale = true;
        }
    }

    /// Splits staged stores into those to memory that no thread can see, which need no boundary,
    /// and the rest.
    pub(crate) fn split(&self, change: Change) -> Result<(Vec<Store>, Change), Error> {
        let (new, again) = self
            .staged
            .before()
            .map_or_else(|| (0..0, BTreeSet::new()), |before| self.arena.since(&before.mark));
        let made = |place: usize| new.contains(&place) || again.contains(&place);
        let (early, late) = split(change.stores, |place| self.staged.is_unseen(place, made(place)));
        if late.len() > MAX_STORES {
            return Err(Error::TooManyStores { stores: late.len() });
        }
        Ok((early, Change { stores: late, lists: change.lists }))
    }

    /// Returns the threads whose lists must be rebuilt from their edges now. While threads are
    /// stopped, lists are rebuilt at the next `start`, unless something is removed that an old list
    /// may hold.
    pub(crate) fn stale_threads(&self, running: bool) -> Vec<Ix> {
        let staged = &self.staged;
        let changed = staged.changed_threads().next().is_some();
        let now = running || staged.starts() || (changed && staged.removes());
        if !now || !(changed || staged.starts()) {
            return Vec::new();
        }
        let touched = staged.changed_threads();
        let mut all: Vec<Ix> = self.graph.threads.values().copied().chain(touched).collect();
        all.retain(|ix| self.graph.thread(*ix).is_some_and(|t| t.stale));
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Notes that threads have received their rebuilt lists.
    pub(crate) fn have_lists(&mut self, threads: Vec<Ix>) {
        for ix in threads {
            if let Some(t) = self.graph.thread_mut(ix) {
                t.stale = false;
            }
        }
    }

    /// Takes the transaction in progress, whose effects remain.
    pub(crate) fn take_staged(&mut self) -> Staged {
        core::mem::take(&mut self.staged)
    }

    /// Ends a transaction whose effects remain.
    pub(crate) fn keep(&mut self, before: Option<Before>) {
        if let Some(before) = before {
            self.arena.keep(before.mark);
        }
    }

    /// Restores counters, lock and memory after all steps have been reverted; keeps the memory if
    /// the revert was not `clean`.
    pub(crate) fn restore(&mut self, before: Before, clean: bool) {
        let now = self.counters;
        self.lock = before.lock;
        self.counters = before.counters;
        if clean {
            self.arena.roll_back(before.mark);
        } else {
            (self.counters.next_component, self.counters.next_thread) =
                (now.next_component, now.next_thread);
            self.arena.keep(before.mark);
        }
    }

    /// Removes all functions from the threads that are restored by [`Self::refill`].
    pub(crate) fn empty(&mut self, orders: &BTreeMap<Ix, Order>) {
        for (thread, _) in orders.iter().filter(|(_, order)| order.functs.is_some()) {
            self.graph.empty_thread(*thread);
        }
    }

    /// Restores the functions of threads.
    pub(crate) fn refill(&mut self, orders: &BTreeMap<Ix, Order>) {
        for (thread, order) in orders {
            self.graph.refill_thread(*thread, order);
        }
    }

    /// Reverts one step of the graph. Components that were created or opened are the caller's to
    /// revert, since their code and threads are involved; they are returned.
    pub(crate) fn revert(&mut self, step: Undo) -> Option<Undo> {
        match step {
            Undo::Made(_) | Undo::Opened(_) => return Some(step),
            Undo::Signal(ix) => self.forget_signal(ix),
            Undo::Named(index, name, ix) => {
                self.graph.remove_name(index, &name, ix);
            }
            Undo::Unnamed(index, name, ix) => self.graph.add_name(index, &name, ix),
            Undo::Linked(pin) => {
                self.graph.remove_link(pin);
            }
            Undo::Unlinked(pin, signal, site) => {
                let edge = self.graph.draw_link(pin, signal);
                self.graph.sites.joined_at(edge, site);
            }
            Undo::Queued(ix) => {
                if let Some(s) = self.graph.signal_mut(ix) {
                    s.queue = None;
                }
            }
            Undo::Aliased(ix, alias, site) => {
                if let Some(item) = self.graph.item_mut(ix) {
                    drop(item.set_alias(alias));
                }
                self.graph.sites.named_at(ix, site);
            }
            Undo::Assigned(ix, values) => self.graph.sites.assigned_before(ix, values),
            Undo::Released(user, provider) => {
                self.graph.g.add_edge(user, provider, Edge::Needs);
            }
            Undo::Ring(name, ring) => {
                self.rings.insert(name, *ring);
            }
        }
        None
    }
}

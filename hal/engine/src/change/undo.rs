//! Log of a transaction's steps in the graph: each entry says how to revert its step.

use crate::{
    Engine,
    graph::sites::{Assignments, Site},
    graph::{Edge, Graph, Ix, Node},
    name::Name,
    observe::ring::SharedRing,
};
use petgraph::{Direction::Outgoing, stable_graph::EdgeIndex, visit::EdgeRef};
use std::collections::BTreeMap;

/// An index of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Index {
    Components,
    Pins,
    Params,
    Signals,
    Functs,
    Threads,
    Commands,
}

impl Index {
    /// Returns the index of pins or of parameters.
    pub(crate) const fn of_items(param: bool) -> Self {
        if param { Self::Params } else { Self::Pins }
    }
}

/// A step of a transaction, with the data to revert it.
#[derive(Debug)]
pub(crate) enum Undo {
    /// A component was created, with everything that it owns.
    Made(Ix),
    /// The component's devices were opened.
    Opened(Ix),
    /// A signal was created.
    Signal(Ix),
    /// A name was added to an index.
    Named(Index, Name),
    /// A name was removed from a node.
    Unnamed(Index, Name, Ix),
    /// A pin was linked.
    Linked(Ix),
    /// A pin was unlinked from a signal; with the script position of the link.
    Unlinked(Ix, Ix, Option<Site>),
    /// A queue was added to a signal.
    Queued(Ix),
    /// A pin or parameter had this alias, set at this script position.
    Aliased(Ix, Option<Name>, Option<Site>),
    /// Script lines had set a pin, parameter or signal to this.
    Assigned(Ix, Option<Assignments>),
    /// A component no longer counts as a user of another.
    Released(Ix, Ix),
    /// A ring was removed from the list of rings.
    Ring(Name, Box<SharedRing>),
}

/// The functions of a thread before the transaction changed them.
#[derive(Debug)]
pub(crate) struct Order {
    /// `None` as long as functions are only added at the end.
    functs: Option<Vec<(Ix, Edge, Option<Site>)>>,
    next: u64,
    stale: bool,
}

impl Graph {
    /// Returns one of the indices of names.
    pub(crate) const fn index_mut(&mut self, index: Index) -> &mut BTreeMap<Name, Ix> {
        match index {
            Index::Components => &mut self.components,
            Index::Pins => &mut self.pins,
            Index::Params => &mut self.params,
            Index::Signals => &mut self.signals,
            Index::Functs => &mut self.functs,
            Index::Threads => &mut self.threads,
            Index::Commands => &mut self.commands,
        }
    }

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
    fn shorten_thread(&mut self, thread: Ix, last: u64) {
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

impl Engine {
    /// Reverts everything, the last step first. Returns false if a new thread cannot be ended:
    /// everything it uses is then kept until it ends.
    pub(crate) fn take_back(&mut self, undo: Vec<Undo>, orders: BTreeMap<Ix, Order>) -> bool {
        let mut clean = true;
        for (thread, _) in orders.iter().filter(|(_, order)| order.functs.is_some()) {
            self.graph.empty_thread(*thread);
        }
        for done in undo.into_iter().rev() {
            match done {
                Undo::Made(component) => clean &= self.discard(component),
                Undo::Opened(component) => self.run_stops(&[component]),
                Undo::Signal(ix) => self.forget_signal(ix),
                Undo::Named(index, name) => {
                    self.graph.index_mut(index).remove(&name);
                }
                Undo::Unnamed(index, name, ix) => {
                    self.graph.index_mut(index).insert(name, ix);
                }
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
                        item.alias = alias;
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
        }
        for (thread, order) in &orders {
            self.graph.refill_thread(*thread, order);
        }
        clean
    }

    /// Removes a signal that has no pins.
    pub(crate) fn forget_signal(&mut self, ix: Ix) {
        if let Some(Node::Signal(s)) = self.graph.g.remove_node(ix) {
            // Another signal may have this name by now.
            if self.graph.signals.get(&s.name) == Some(&ix) {
                self.graph.signals.remove(&s.name);
            }
            self.graph.sites.forget(ix);
            self.arena.give_cell(s.cell.0);
            drop(s.queue);
        }
    }
}

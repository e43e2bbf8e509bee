//! The graph: components, pins, parameters, signals, functions and threads, and every edge between
//! them. Names are indices into it; no other structure stores links.

pub(crate) mod arena;
pub(crate) mod doc;
pub(crate) mod item;
pub(crate) mod listing;
mod lookup;
mod measured;
pub(crate) mod model;
pub(crate) mod names;
pub(crate) mod new_item;
pub(crate) mod node;
pub(crate) mod own;
pub(crate) mod ptr;
pub(crate) mod removal;
pub(crate) mod schedule;
pub(crate) mod sites;
mod staging;
pub(crate) mod value;
pub(crate) mod wired;
pub(crate) mod wiring;

use crate::{
    Error, error::near::nearest, graph::doc::Docs, graph::names::Names, graph::sites::Sites,
    name::Name,
};
use core::ptr::NonNull;
use hal_abi::{PortQueue, Slot};
use hal_protocol::{Type, Value};
use petgraph::{
    Direction::{Incoming, Outgoing},
    stable_graph::{NodeIndex, StableDiGraph},
    visit::EdgeRef,
};
use std::collections::BTreeMap;

pub(crate) use crate::graph::node::{
    Command, Component, Edge, Foreign, Funct, Item, Node, Queue, Service, Signal, Storage,
    ThreadNode,
};

pub(crate) type Ix = NodeIndex<u32>;

/// The graph and the names of its nodes.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    pub(crate) g: StableDiGraph<Node, Edge, u32>,
    pub(crate) components: BTreeMap<Name, Ix>,
    pins: Names,
    params: Names,
    signals: Names,
    functs: Names,
    pub(crate) threads: BTreeMap<Name, Ix>,
    pub(crate) commands: BTreeMap<Name, Ix>,
    pub(crate) sites: Sites,
    pub(crate) docs: Docs,
    /// Names that items have in machines of the old kind, with those that they have here.
    former: BTreeMap<Name, Name>,
}

macro_rules! node {
    ($get:ident, $variant:ident, $ty:ty) => {
        #[doc = concat!("The node, if it is a ", stringify!($variant), ".")]
        pub(crate) fn $get(&self, ix: Ix) -> Option<&$ty> {
            match self.g.node_weight(ix) {
                Some(Node::$variant(x)) => {
                    let x: &$ty = x;
                    Some(x)
                }
                _ => None,
            }
        }
    };
    ($get:ident, $get_mut:ident, $variant:ident, $ty:ty) => {
        node!($get, $variant, $ty);
        #[doc = concat!("The node, if it is a ", stringify!($variant), ".")]
        pub(crate) fn $get_mut(&mut self, ix: Ix) -> Option<&mut $ty> {
            match self.g.node_weight_mut(ix) {
                Some(Node::$variant(x)) => {
                    let x: &mut $ty = x;
                    Some(x)
                }
                _ => None,
            }
        }
    };
}

impl Graph {
    node!(component, component_mut, Component, Component);
    node!(item, item_mut, Item, Item);
    node!(signal, signal_mut, Signal, Signal);
    node!(funct, funct_mut, Funct, Funct);
    node!(thread, thread_mut, Thread, ThreadNode);

    /// Finds the pin or parameter with this name. A pin takes precedence.
    pub(crate) fn find_item(&self, name: &str) -> Result<Ix, Error> {
        let found = self.item_named(false, name).or_else(|| self.item_named(true, name));
        found.ok_or_else(|| {
            let names = self.all_item_names().map(|(name, _)| name.as_str());
            let what = "parameter or pin";
            Error::NoItem { what, name: name.into(), near: self.near(name, names) }
        })
    }

    /// Returns the name that an unknown name of an item probably stands for: the present one of a former name, or the nearest
    /// of `names`.
    pub(crate) fn near<'n>(
        &self,
        word: &str,
        names: impl IntoIterator<Item = &'n str>,
    ) -> Option<Box<str>> {
        let is_there = |name: &&Name| {
            [false, true].into_iter().any(|param| self.item_named(param, name.as_str()).is_some())
        };
        let now = self.former.get(word).filter(is_there);
        now.map(|name| name.as_str().into()).or_else(|| nearest(word, names))
    }

    /// Finds the pin with this name.
    pub(crate) fn find_pin(&self, name: &str) -> Result<Ix, Error> {
        self.find_of(false, "pin", name)
    }

    /// Finds the parameter with this name if `param` is true, otherwise the pin.
    pub(crate) fn find_of(&self, param: bool, what: &'static str, name: &str) -> Result<Ix, Error> {
        self.item_named(param, name).ok_or_else(|| {
            let names = self.item_names(param);
            let names = names.iter().map(|(name, _)| name.as_str());
            Error::NotFound { what, name: name.into(), near: self.near(name, names) }
        })
    }

    /// Finds the signal with this name.
    pub(crate) fn find_signal(&self, name: &str) -> Result<Ix, Error> {
        found(self.signal_named(name), "signal", name, || self.signal_names())
    }

    /// Finds the function with this name.
    pub(crate) fn find_funct(&self, name: &str) -> Result<Ix, Error> {
        found(self.funct_named(name), "function", name, || self.funct_names())
    }

    /// Finds the thread with this name.
    pub(crate) fn find_thread(&self, name: &str) -> Result<Ix, Error> {
        find(&self.threads, "thread", name)
    }

    /// Returns the name of a function by its number.
    pub(crate) fn funct_name(&self, id: u32) -> String {
        let funct = self.funct(Ix::from(id));
        funct.map_or_else(|| "?".to_owned(), |f| f.name.as_str().to_owned())
    }

    /// Returns the item that owns a slot, of any component.
    pub(crate) fn item_at(&self, slot: *const Slot) -> Option<Ix> {
        let is_its = |s: NonNull<Slot>| s.as_ptr().cast_const() == slot;
        self.g.node_indices().find(|ix| self.item(*ix).and_then(Item::slot).is_some_and(is_its))
    }

    /// Finds a service, and the component that offers it.
    pub(crate) fn service(&self, name: &str, version: Option<u32>) -> Option<(Ix, &Service)> {
        self.components.values().find_map(|ix| {
            let service = self
                .component(*ix)?
                .services
                .iter()
                .find(|s| &*s.name == name && version.is_none_or(|v| v == s.version))?;
            Some((*ix, service))
        })
    }

    /// Returns the signal that a pin is linked to.
    pub(crate) fn signal_of(&self, pin: Ix) -> Option<Ix> {
        self.g
            .edges_directed(pin, Outgoing)
            .find(|e| *e.weight() == Edge::Links)
            .map(|e| e.target())
    }

    /// Returns the pins of a signal.
    pub(crate) fn pins_of(&self, signal: Ix) -> Vec<Ix> {
        let links = self.g.edges_directed(signal, Incoming).filter(|e| *e.weight() == Edge::Links);
        links.map(|e| e.source()).collect()
    }

    /// Returns the component that created a node.
    pub(crate) fn owner(&self, ix: Ix) -> Option<&Component> {
        self.component(self.owner_of(ix)?)
    }

    /// Returns the node of the component that created a node.
    pub(crate) fn owner_of(&self, ix: Ix) -> Option<Ix> {
        let mut edges = self.g.edges_directed(ix, Incoming);
        edges.find(|e| *e.weight() == Edge::Owns).map(|e| e.source())
    }

    /// Returns the nodes that a component created, newest first.
    pub(crate) fn owned(&self, component: Ix) -> Vec<Ix> {
        let owns = self.g.edges_directed(component, Outgoing).filter(|e| *e.weight() == Edge::Owns);
        owns.map(|e| e.target()).collect()
    }

    /// Returns the components that use a service of this one.
    pub(crate) fn users(&self, component: Ix) -> Vec<Ix> {
        let needs =
            self.g.edges_directed(component, Incoming).filter(|e| *e.weight() == Edge::Needs);
        needs.map(|e| e.source()).collect()
    }

    /// Removes the edges from a component to those whose services it used, and returns the latter.
    pub(crate) fn needed_by(&mut self, component: Ix) -> Vec<Ix> {
        let needs =
            self.g.edges_directed(component, Outgoing).filter(|e| *e.weight() == Edge::Needs);
        let (edges, providers): (Vec<_>, Vec<_>) = needs.map(|e| (e.id(), e.target())).unzip();
        for edge in edges {
            self.g.remove_edge(edge);
        }
        providers
    }

    /// Returns the functions of a thread in order: those that run once (`init`), or those of every
    /// cycle.
    pub(crate) fn runs(&self, thread: Ix, init: bool) -> Vec<Ix> {
        let mut list: Vec<(u32, Ix)> = self
            .g
            .edges_directed(thread, Outgoing)
            .filter_map(|e| match (*e.weight(), init) {
                (Edge::Runs(at), false) | (Edge::Begins(at), true) => Some((at, e.target())),
                _ => None,
            })
            .collect();
        list.sort_unstable();
        list.into_iter().map(|(_, ix)| ix).collect()
    }

    /// Returns the threads that run a function.
    pub(crate) fn threads_of(&self, funct: Ix) -> Vec<Ix> {
        self.g
            .edges_directed(funct, Incoming)
            .filter(|e| matches!(e.weight(), Edge::Runs(_) | Edge::Begins(_)))
            .map(|e| e.source())
            .collect()
    }

    /// Returns whether any thread runs a function.
    pub(crate) fn is_in_use(&self, funct: Ix) -> bool {
        !self.threads_of(funct).is_empty()
    }

    /// Returns the threads in order of creation.
    pub(crate) fn threads_by_age(&self) -> Vec<Ix> {
        let mut list: Vec<(u32, Ix)> = self
            .threads
            .values()
            .filter_map(|ix| self.thread(*ix).map(|t| (t.thread.id, *ix)))
            .collect();
        list.sort_unstable();
        list.into_iter().map(|(_, ix)| ix).collect()
    }

    /// Returns the components, oldest first.
    pub(crate) fn components_by_age(&self) -> Vec<Ix> {
        let mut list: Vec<(u32, Ix)> = self
            .components
            .values()
            .filter_map(|ix| self.component(*ix).map(|c| (c.id, *ix)))
            .collect();
        list.sort_unstable();
        list.into_iter().map(|(_, ix)| ix).collect()
    }

    /// Returns a value as users see it. For a port, this is the size of its queue.
    pub(crate) fn value(ty: Type, bits: u64) -> Value {
        if ty != Type::Port {
            return Value::from_bits(ty, bits);
        }
        let address = usize::try_from(bits).unwrap_or(0);
        let queue: *const PortQueue = core::ptr::with_exposed_provenance(address);
        // SAFETY: only the engine writes to cells of type `port`, and it stores only addresses of
        // live queues.
        Value::Port(unsafe { queue.as_ref() }.map_or(0, PortQueue::size))
    }
}

/// Returns a node that was looked up by name, or an error with the nearest of `all` names.
fn found<'g>(
    ix: Option<Ix>,
    what: &'static str,
    name: &str,
    all: impl FnOnce() -> Vec<(&'g Name, Ix)>,
) -> Result<Ix, Error> {
    ix.ok_or_else(|| Error::NotFound {
        what,
        name: name.into(),
        near: nearest(name, all().into_iter().map(|(name, _)| name.as_str())),
    })
}

/// Returns the node with this name, or an error with the nearest name.
pub(crate) fn find(
    names: &BTreeMap<Name, Ix>,
    what: &'static str,
    name: &str,
) -> Result<Ix, Error> {
    found(names.get(name).copied(), what, name, || names.iter().map(|(n, ix)| (n, *ix)).collect())
}

//! The graph: components, pins, parameters, signals, functions and threads, and every edge
//! between them. Names index into it; no other structure stores a link.

use crate::{Error, name::Name, near::nearest, sites::Sites, sync::Arc};
use hal_abi::PortQueue;
use hal_protocol::{Type, Value};
use petgraph::{
    Direction::{Incoming, Outgoing},
    stable_graph::{NodeIndex, StableDiGraph},
    visit::EdgeRef,
};
use std::collections::BTreeMap;

pub(crate) use crate::node::{
    Command, Component, Edge, Foreign, Funct, Item, Node, Queue, Service, Signal, Storage,
    ThreadNode,
};

pub(crate) type Ix = NodeIndex<u32>;

/// The graph and its names.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    pub(crate) g: StableDiGraph<Node, Edge, u32>,
    pub(crate) components: BTreeMap<Name, Ix>,
    pub(crate) pins: BTreeMap<Name, Ix>,
    pub(crate) params: BTreeMap<Name, Ix>,
    pub(crate) signals: BTreeMap<Name, Ix>,
    pub(crate) functs: BTreeMap<Name, Ix>,
    pub(crate) threads: BTreeMap<Name, Ix>,
    pub(crate) commands: BTreeMap<Name, Ix>,
    pub(crate) sites: Sites,
    docs: BTreeMap<Box<str>, Arc<str>>,
}

macro_rules! node {
    ($get:ident, $variant:ident, $ty:ty) => {
        #[doc = concat!("The node, if it is a ", stringify!($variant), ".")]
        pub(crate) fn $get(&self, ix: Ix) -> Option<&$ty> {
            match self.g.node_weight(ix) {
                Some(Node::$variant(x)) => Some(x),
                _ => None,
            }
        }
    };
    ($get:ident, $get_mut:ident, $variant:ident, $ty:ty) => {
        node!($get, $variant, $ty);
        #[doc = concat!("The node, if it is a ", stringify!($variant), ".")]
        pub(crate) fn $get_mut(&mut self, ix: Ix) -> Option<&mut $ty> {
            match self.g.node_weight_mut(ix) {
                Some(Node::$variant(x)) => Some(x),
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

    /// One copy of each documentation text.
    pub(crate) fn doc(&mut self, text: &str) -> Arc<str> {
        if let Some(doc) = self.docs.get(text) {
            return doc.clone();
        }
        let doc: Arc<str> = text.into();
        self.docs.insert(text.into(), doc.clone());
        doc
    }

    /// The names of pins or of parameters.
    pub(crate) const fn names(&self, param: bool) -> &BTreeMap<Name, Ix> {
        if param { &self.params } else { &self.pins }
    }

    /// The names of pins or of parameters.
    pub(crate) const fn names_mut(&mut self, param: bool) -> &mut BTreeMap<Name, Ix> {
        if param { &mut self.params } else { &mut self.pins }
    }

    /// A pin or parameter of this name, pins first.
    pub(crate) fn find_item(&self, name: &str) -> Result<Ix, Error> {
        let found = self.pins.get(name).or_else(|| self.params.get(name)).copied();
        found.ok_or_else(|| {
            let names = self.pins.keys().chain(self.params.keys()).map(Name::as_str);
            let what = "parameter or pin";
            Error::NoItem { what, name: name.into(), near: nearest(name, names) }
        })
    }

    /// A pin of this name.
    pub(crate) fn find_pin(&self, name: &str) -> Result<Ix, Error> {
        find(&self.pins, "pin", name)
    }

    /// A signal of this name.
    pub(crate) fn find_signal(&self, name: &str) -> Result<Ix, Error> {
        find(&self.signals, "signal", name)
    }

    /// A function of this name.
    pub(crate) fn find_funct(&self, name: &str) -> Result<Ix, Error> {
        find(&self.functs, "function", name)
    }

    /// A thread of this name.
    pub(crate) fn find_thread(&self, name: &str) -> Result<Ix, Error> {
        find(&self.threads, "thread", name)
    }

    /// The signal that a pin is linked to.
    pub(crate) fn signal_of(&self, pin: Ix) -> Option<Ix> {
        self.g
            .edges_directed(pin, Outgoing)
            .find(|e| *e.weight() == Edge::Links)
            .map(|e| e.target())
    }

    /// The pins of a signal.
    pub(crate) fn pins_of(&self, signal: Ix) -> Vec<Ix> {
        let links = self.g.edges_directed(signal, Incoming).filter(|e| *e.weight() == Edge::Links);
        links.map(|e| e.source()).collect()
    }

    /// The component that made a node.
    pub(crate) fn owner(&self, ix: Ix) -> Option<&Component> {
        self.component(self.owner_of(ix)?)
    }

    /// The node of the component that made a node.
    pub(crate) fn owner_of(&self, ix: Ix) -> Option<Ix> {
        let mut edges = self.g.edges_directed(ix, Incoming);
        edges.find(|e| *e.weight() == Edge::Owns).map(|e| e.source())
    }

    /// What a component made, newest first.
    pub(crate) fn owned(&self, component: Ix) -> Vec<Ix> {
        let owns = self.g.edges_directed(component, Outgoing).filter(|e| *e.weight() == Edge::Owns);
        owns.map(|e| e.target()).collect()
    }

    /// The components that use a service of this one.
    pub(crate) fn users(&self, component: Ix) -> Vec<Ix> {
        let needs =
            self.g.edges_directed(component, Incoming).filter(|e| *e.weight() == Edge::Needs);
        needs.map(|e| e.source()).collect()
    }

    /// The components whose services this one used; it does not any more.
    pub(crate) fn needed_by(&mut self, component: Ix) -> Vec<Ix> {
        let needs =
            self.g.edges_directed(component, Outgoing).filter(|e| *e.weight() == Edge::Needs);
        let (edges, providers): (Vec<_>, Vec<_>) = needs.map(|e| (e.id(), e.target())).unzip();
        for edge in edges {
            self.g.remove_edge(edge);
        }
        providers
    }

    /// The functions of a thread in order: those that run once, or those of every cycle.
    pub(crate) fn runs(&self, thread: Ix, init: bool) -> Vec<Ix> {
        let mut list: Vec<(u64, Ix)> = self
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

    /// The threads that run a function.
    pub(crate) fn threads_of(&self, funct: Ix) -> Vec<Ix> {
        self.g
            .edges_directed(funct, Incoming)
            .filter(|e| matches!(e.weight(), Edge::Runs(_) | Edge::Begins(_)))
            .map(|e| e.source())
            .collect()
    }

    /// Whether any thread runs a function.
    pub(crate) fn is_in_use(&self, funct: Ix) -> bool {
        !self.threads_of(funct).is_empty()
    }

    /// The threads in order of creation.
    pub(crate) fn threads_by_age(&self) -> Vec<Ix> {
        let mut list: Vec<(u32, Ix)> = self
            .threads
            .values()
            .filter_map(|ix| self.thread(*ix).map(|t| (t.thread.id, *ix)))
            .collect();
        list.sort_unstable();
        list.into_iter().map(|(_, ix)| ix).collect()
    }

    /// The components, oldest first.
    pub(crate) fn components_by_age(&self) -> Vec<Ix> {
        let mut list: Vec<(u32, Ix)> = self
            .components
            .values()
            .filter_map(|ix| self.component(*ix).map(|c| (c.id, *ix)))
            .collect();
        list.sort_unstable();
        list.into_iter().map(|(_, ix)| ix).collect()
    }

    /// A value as users see it: of a port, the size of its queue.
    pub(crate) fn value(ty: Type, bits: u64) -> Value {
        if ty != Type::Port {
            return Value::from_bits(ty, bits);
        }
        let address = usize::try_from(bits).unwrap_or(0);
        let queue: *const PortQueue = core::ptr::with_exposed_provenance(address);
        // SAFETY: only the engine puts addresses into cells of type port, of live queues.
        Value::Port(unsafe { queue.as_ref() }.map_or(0, PortQueue::size))
    }
}

/// A name's node, or the nearest name.
pub(crate) fn find(
    names: &BTreeMap<Name, Ix>,
    what: &'static str,
    name: &str,
) -> Result<Ix, Error> {
    names.get(name).copied().ok_or_else(|| Error::NotFound {
        what,
        name: name.into(),
        near: nearest(name, names.keys().map(Name::as_str)),
    })
}

//! The graph: components, pins, parameters, signals, functions and threads, and every edge
//! between them. Names index into it; no other structure stores a link.

use crate::{
    Error,
    args::Declared,
    code::{Code, Ptr},
    name::Name,
    near::nearest,
    sync::Arc,
    thread::{Account, Thread},
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{Cell, CommandRun, PortQueue, Run, Slot};
use hal_protocol::{ComponentState, Direction, Type, Value};
use petgraph::{
    Direction::{Incoming, Outgoing},
    stable_graph::{NodeIndex, StableDiGraph},
    visit::EdgeRef,
};
use std::collections::BTreeMap;

pub(crate) type Ix = NodeIndex<u32>;

/// A node.
#[derive(Debug)]
pub(crate) enum Node {
    Component(Component),
    Item(Item),
    Signal(Signal),
    Funct(Funct),
    Thread(ThreadNode),
}

/// An edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Edge {
    /// Component to what it made.
    Owns,
    /// Pin to signal.
    Links,
    /// Pin or parameter to the function that reads it.
    Reads,
    /// Function to the pin or parameter that it writes.
    Writes,
    /// Function to the function that takes its hidden state.
    HandsOver,
    /// Thread to function, by position.
    Runs(u64),
    /// Thread to function, once before all others, by position.
    Begins(u64),
    /// Component to the component whose service it uses.
    Needs,
}

/// A component: one load of a plugin, or a program.
#[derive(Debug)]
pub(crate) struct Component {
    pub(crate) id: u32,
    pub(crate) name: Name,
    pub(crate) pid: Option<i32>,
    pub(crate) realtime: bool,
    pub(crate) state: ComponentState,
    pub(crate) args: Option<String>,
    pub(crate) commands: Vec<Command>,
    pub(crate) stops: Vec<Code<CommandRun>>,
    pub(crate) services: Vec<Service>,
}

/// A command that a component offers.
#[derive(Debug)]
pub(crate) struct Command {
    pub(crate) name: Name,
    pub(crate) doc: Box<str>,
    pub(crate) args: Vec<Declared>,
    pub(crate) code: Code<CommandRun>,
}

/// A table that a component offers to others.
#[derive(Debug)]
pub(crate) struct Service {
    pub(crate) name: Box<str>,
    pub(crate) version: u32,
    pub(crate) table: *const c_void,
    #[expect(dead_code, reason = "held so that the table lives as long as its component")]
    pub(crate) code: Code<()>,
}

/// Where a value is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Storage {
    /// In the arena.
    Slot(Ptr<Slot>),
    /// In the component's own memory, at the width of its type.
    Own(NonNull<c_void>),
}

/// A pin or parameter.
#[derive(Debug)]
pub(crate) struct Item {
    pub(crate) name: Name,
    /// Another name for look-up: the old one, or the new one where the old is shown.
    pub(crate) other: Option<Name>,
    pub(crate) alias: Option<Name>,
    pub(crate) ty: Type,
    pub(crate) direction: Direction,
    pub(crate) storage: Storage,
    pub(crate) hidden: bool,
    /// Made by the engine: times of functions and threads.
    pub(crate) times: bool,
    pub(crate) doc: Arc<str>,
}

impl Item {
    /// The name it is listed under.
    pub(crate) fn shown(&self) -> &Name {
        self.alias.as_ref().unwrap_or(&self.name)
    }

    /// Its slot; pins always have one.
    pub(crate) const fn slot(&self) -> Option<NonNull<Slot>> {
        match self.storage {
            Storage::Slot(p) => Some(p.0),
            Storage::Own(_) => None,
        }
    }

    /// Its value now, as its type's bits.
    pub(crate) fn bits(&self) -> u64 {
        match self.storage {
            // SAFETY: a live slot of the arena.
            Storage::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.load(),
            Storage::Own(p) => own::load(p, self.ty),
        }
    }

    /// Sets its value.
    pub(crate) fn put(&self, bits: u64) {
        match self.storage {
            // SAFETY: a live slot of the arena.
            Storage::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.store(bits),
            Storage::Own(p) => own::store(p, self.ty, bits),
        }
    }
}

/// Values in a component's own memory.
mod own {
    use crate::sync::{
        AtomicU8, AtomicU32, AtomicU64,
        Ordering::{Acquire, Release},
    };
    use core::{ffi::c_void, ptr::NonNull};
    use hal_protocol::Type;

    pub(super) fn load(p: NonNull<c_void>, ty: Type) -> u64 {
        match ty {
            // SAFETY: the component gave storage of this type, alive as long as it is.
            Type::Bit => u64::from(unsafe { p.cast::<AtomicU8>().as_ref() }.load(Acquire)),
            Type::S32 | Type::U32 | Type::Port => {
                // SAFETY: as above.
                u64::from(unsafe { p.cast::<AtomicU32>().as_ref() }.load(Acquire))
            }
            // SAFETY: as above.
            _ => unsafe { p.cast::<AtomicU64>().as_ref() }.load(Acquire),
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "stored at exactly its width")]
    pub(super) fn store(p: NonNull<c_void>, ty: Type, bits: u64) {
        match ty {
            // SAFETY: the component gave storage of this type, alive as long as it is.
            Type::Bit => unsafe { p.cast::<AtomicU8>().as_ref() }.store(bits as u8, Release),
            Type::S32 | Type::U32 | Type::Port => {
                // SAFETY: as above.
                unsafe { p.cast::<AtomicU32>().as_ref() }.store(bits as u32, Release);
            }
            // SAFETY: as above.
            _ => unsafe { p.cast::<AtomicU64>().as_ref() }.store(bits, Release),
        }
    }
}

/// The queue of a signal of type port.
#[derive(Debug)]
pub(crate) struct Queue {
    #[expect(dead_code, reason = "cells hold its address")]
    pub(crate) queue: Box<PortQueue>,
    #[expect(dead_code, reason = "the queue points into it")]
    pub(crate) data: Box<[crate::sync::AtomicU8]>,
}

/// A signal.
#[derive(Debug)]
pub(crate) struct Signal {
    pub(crate) name: Name,
    pub(crate) ty: Type,
    pub(crate) cell: Ptr<Cell>,
    pub(crate) queue: Option<Queue>,
    pub(crate) readers: u32,
    pub(crate) writers: u32,
    pub(crate) bidirs: u32,
}

impl Signal {
    /// Its value now, as its type's bits.
    pub(crate) fn bits(&self) -> u64 {
        // SAFETY: a live cell of the arena.
        unsafe { self.cell.0.as_ref() }.load()
    }

    /// Counts a pin in or out.
    pub(crate) const fn count(&mut self, direction: Direction, up: bool) {
        match direction {
            Direction::In => self.readers = add_one(self.readers, up),
            Direction::Out => self.writers = add_one(self.writers, up),
            Direction::Io => {
                self.bidirs = add_one(self.bidirs, up);
                self.readers = add_one(self.readers, up);
            }
            Direction::Ro | Direction::Rw => {}
        }
    }
}

const fn add_one(n: u32, up: bool) -> u32 {
    if up { n + 1 } else { n.saturating_sub(1) }
}

/// A function.
#[derive(Debug)]
pub(crate) struct Funct {
    pub(crate) name: Name,
    pub(crate) reentrant: bool,
    pub(crate) code: Arc<Code<Run>>,
    pub(crate) account: Account,
    pub(crate) users: u32,
}

/// A thread.
#[derive(Debug)]
pub(crate) struct ThreadNode {
    pub(crate) name: Name,
    pub(crate) thread: Arc<Thread>,
    /// The position of the next function at the end.
    pub(crate) next: u64,
    /// Whether its list is older than its edges.
    pub(crate) stale: bool,
}

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
    docs: BTreeMap<Box<str>, Arc<str>>,
}

macro_rules! node {
    ($get:ident, $get_mut:ident, $variant:ident, $ty:ty) => {
        #[doc = concat!("The node, if it is a ", stringify!($variant), ".")]
        pub(crate) fn $get(&self, ix: Ix) -> Option<&$ty> {
            match self.g.node_weight(ix) {
                Some(Node::$variant(x)) => Some(x),
                _ => None,
            }
        }
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
            Error::NoItem { name: name.into(), near: nearest(name, names) }
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
        let edge = self.g.edges_directed(ix, Incoming).find(|e| *e.weight() == Edge::Owns)?;
        self.component(edge.source())
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

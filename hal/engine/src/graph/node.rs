//! Nodes and edges of the graph.

use crate::{
    ends::{Doing, Origin},
    graph::doc::Doc,
    graph::new_item::NewItem,
    graph::own,
    graph::ptr::Pointer,
    graph::ptr::Ptr,
    load::args::Declared,
    load::code::{Code, LoadHandle},
    name::Name,
    realtime::account::Account,
    realtime::thread::Thread,
    sync::Arc,
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{Cell, CommandRun, PortQueue, Run, Slot, Use};
use hal_protocol::{ComponentState, Direction, Type};

/// A node of the graph. Most nodes are items; the size of an item is the size of a node, so the
/// others are boxed.
#[derive(Debug)]
pub(crate) enum Node {
    Component(Box<Component>),
    Item(Item),
    Signal(Box<Signal>),
    Funct(Box<Funct>),
    Thread(Box<ThreadNode>),
}

// A machine may have a million items.
const _: () = assert!(size_of::<Node>() == 40 && size_of::<Edge>() == 8);

/// An edge of the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Edge {
    /// From a component to what it created.
    Owns,
    /// From a pin to its signal.
    Links,
    /// From a pin or parameter to a function that reads it.
    Reads,
    /// From a function to a pin or parameter that it writes.
    Writes,
    /// From a function to a function that takes its hidden state.
    HandsOver,
    /// From a thread to a function of every cycle, with its position.
    Runs(u32),
    /// From a thread to a function that runs once before all others, with its position.
    Begins(u32),
    /// From a component to a component whose service it uses.
    Needs,
}

impl Edge {
    /// Returns the position of a function in a thread, from 1.
    pub(crate) const fn place(self) -> Option<u32> {
        match self {
            Self::Runs(at) | Self::Begins(at) => Some(at),
            Self::Owns
            | Self::Links
            | Self::Reads
            | Self::Writes
            | Self::HandsOver
            | Self::Needs => None,
        }
    }
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
    pub(crate) stops: Vec<Arc<Code<CommandRun>>>,
    /// File that contains its code.
    pub(crate) origin: Option<Origin>,
    pub(crate) services: Vec<Service>,
    /// Origin of a component that is not a plugin.
    pub(crate) foreign: Option<Foreign>,
}

/// A file that is not a plugin.
#[derive(Debug)]
pub(crate) struct Foreign {
    pub(crate) kind: Box<str>,
    pub(crate) module: Box<str>,
    pub(crate) prefix: Box<str>,
    pub(crate) file: Box<str>,
    pub(crate) doc: Box<str>,
    pub(crate) keep: Arc<LoadHandle>,
}

/// A command that a component offers.
#[derive(Debug)]
pub(crate) struct Command {
    pub(crate) name: Name,
    pub(crate) doc: Box<str>,
    pub(crate) args: Vec<Declared>,
    pub(crate) code: Code<CommandRun>,
    /// Description of the command for the report of a crash.
    pub(crate) doing: Arc<Doing>,
}

/// A function table that a component offers to others.
#[derive(Debug)]
pub(crate) struct Service {
    pub(crate) name: Box<str>,
    pub(crate) version: u32,
    pub(crate) table: *const c_void,
    /// Pins, parameters and hidden state that its functions access.
    pub(crate) uses: Vec<Use>,
    #[expect(dead_code, reason = "held so that the table lives as long as its component")]
    pub(crate) code: Code<()>,
}

/// Location of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Storage {
    /// In the arena.
    Slot(Ptr<Slot>),
    /// In the component's own memory, as wide as its type.
    Own(NonNull<c_void>),
}

/// A pin or parameter.
#[derive(Debug)]
pub(crate) struct Item {
    pub(crate) name: Name,
    /// Address of the slot, or of the value in the component's own memory.
    address: NonNull<c_void>,
    rare: Option<Box<Rare>>,
    pub(crate) doc: Doc,
    pub(crate) ty: Type,
    pub(crate) direction: Direction,
    /// True for items that the engine creates: times of functions and threads.
    pub(crate) times: bool,
    /// True if the value is in the component's own memory.
    own: bool,
}

/// Properties that few items have.
#[derive(Debug, Default)]
struct Rare {
    other: Option<Name>,
    alias: Option<Name>,
    pointer: Option<Pointer>,
    hidden: bool,
    safety: bool,
    measured: bool,
}

impl Item {
    /// Creates an item whose value is at `storage`.
    pub(crate) fn new(new: NewItem, storage: Storage) -> Self {
        let NewItem { name, other, ty, direction, hidden, times, safety, measured, doc, .. } = new;
        let (address, own) = match storage {
            Storage::Slot(p) => (p.0.cast(), false),
            Storage::Own(p) => (p, true),
        };
        let rare = Rare { other, hidden, safety, measured, ..Rare::default() };
        let is_rare = rare.other.is_some() || hidden || safety || measured;
        let rare = is_rare.then(|| Box::new(rare));
        Self { name, address, rare, doc, ty, direction, times, own }
    }

    /// Returns the location of the value.
    pub(crate) const fn storage(&self) -> Storage {
        if self.own { Storage::Own(self.address) } else { Storage::Slot(Ptr(self.address.cast())) }
    }

    /// Returns the second name for look-ups: the old name, or the new name if the old one is shown.
    pub(crate) fn other(&self) -> Option<&Name> {
        self.rare.as_ref()?.other.as_ref()
    }

    /// Returns the alias.
    pub(crate) fn alias(&self) -> Option<&Name> {
        self.rare.as_ref()?.alias.as_ref()
    }

    /// Sets the alias, or removes it. Returns the one before.
    pub(crate) fn set_alias(&mut self, alias: Option<Name>) -> Option<Name> {
        if alias.is_none() && self.rare.is_none() {
            return None;
        }
        core::mem::replace(&mut self.rare.get_or_insert_default().alias, alias)
    }

    /// Returns the place where foreign code keeps the address of the pin's cell.
    pub(crate) fn pointer(&self) -> Option<Pointer> {
        self.rare.as_ref()?.pointer
    }

    /// Sets the place where foreign code keeps the address of the pin's cell.
    pub(crate) fn set_pointer(&mut self, pointer: Pointer) {
        self.rare.get_or_insert_default().pointer = Some(pointer);
    }

    /// Returns whether the item is listed only if a pattern names it.
    pub(crate) fn hidden(&self) -> bool {
        self.rare.as_ref().is_some_and(|r| r.hidden)
    }

    /// Returns whether the item is a limit switch or an e-stop input.
    pub(crate) fn safety(&self) -> bool {
        self.rare.as_ref().is_some_and(|r| r.safety)
    }

    /// Returns whether a sensor measures the value.
    pub(crate) fn is_measured(&self) -> bool {
        self.rare.as_ref().is_some_and(|r| r.measured)
    }

    /// Returns the name under which the item is listed.
    pub(crate) fn shown(&self) -> &Name {
        self.alias().unwrap_or(&self.name)
    }

    /// Returns the slot. Pins always have one.
    pub(crate) const fn slot(&self) -> Option<NonNull<Slot>> {
        match self.storage() {
            Storage::Slot(p) => Some(p.0),
            Storage::Own(_) => None,
        }
    }

    /// Returns the current value as bits of a cell.
    pub(crate) fn bits(&self) -> u64 {
        match self.storage() {
            // SAFETY: the slot is a live slot of the arena.
            Storage::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.load(),
            Storage::Own(p) => own::load(p, self.ty),
        }
    }

    /// Sets the value.
    pub(crate) fn put(&self, bits: u64) {
        match self.storage() {
            // SAFETY: the slot is a live slot of the arena.
            Storage::Slot(p) => unsafe { Slot::cell(p.0.as_ptr()) }.store(bits),
            Storage::Own(p) => own::store(p, self.ty, bits),
        }
    }
}

/// Queue of a signal of type `port`.
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
    /// Returns the current value as bits of a cell.
    pub(crate) fn bits(&self) -> u64 {
        // SAFETY: the cell is a live cell of the arena.
        unsafe { self.cell.0.as_ref() }.load()
    }

    /// Adds a pin to the signal's counts (`up`) or removes it.
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
    /// True if the pins that it reads and writes are unknown.
    pub(crate) unknown: bool,
    /// True if it belongs in a fast thread.
    pub(crate) fast: bool,
    /// True if it computes with floating-point numbers.
    pub(crate) fp: bool,
    pub(crate) doc: Doc,
    /// True if it takes hidden state that no function produces: commands, or results of a
    /// background task.
    pub(crate) told: bool,
    pub(crate) code: Arc<Code<Run>>,
    pub(crate) account: Account,
}

/// A thread.
#[derive(Debug)]
pub(crate) struct ThreadNode {
    pub(crate) name: Name,
    pub(crate) thread: Arc<Thread>,
    /// True if functions that compute with floating-point numbers can be added.
    pub(crate) fp: bool,
    /// Highest position assigned so far.
    pub(crate) next: u32,
    /// True if the thread's function list is older than its edges.
    pub(crate) stale: bool,
}

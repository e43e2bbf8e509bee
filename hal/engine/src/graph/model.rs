//! The model of the machine: the graph with the memory of its values, the loader, and the staged
//! changes to them.
//!
//! Only the files of this room see the fields. All others read the graph through [`Model::graph`]
//! and change it by methods, which record how to revert each step.

use crate::{
    Error,
    change::staged::{Counters, Staged},
    graph::arena::Arena,
    graph::doc::Doc,
    graph::measured::Question,
    graph::names::Index,
    graph::ptr::Pointer,
    graph::sites::Site,
    graph::{Command, Component, Edge, Funct, Graph, Ix, Node},
    load::loader::Loader,
    name::Name,
    observe::ring::SharedRing,
};
use hal_protocol::{At, Lock, Type};
use std::{collections::BTreeMap, path::PathBuf};

/// Graph, values and loader of an instance, with the transaction in progress.
#[derive(Debug)]
pub(crate) struct Model {
    pub(in crate::graph) graph: Graph,
    pub(in crate::graph) counters: Counters,
    pub(in crate::graph) staged: Staged,
    pub(in crate::graph) lock: Lock,
    /// Shared rings of streams.
    pub(in crate::graph) rings: BTreeMap<Name, SharedRing>,
    loader: Loader,
    /// Questions of components whether their pins are measured.
    pub(in crate::graph) questions: Vec<Question>,
    /// Components that have been unloaded or are about to be; a stuck thread may still hold some of
    /// them.
    departed: Vec<Ix>,
    /// The last field: everything else points into it.
    pub(in crate::graph) arena: Arena,
}

impl Model {
    /// Creates an empty model that loads from these folders; `lock` keeps the values in memory.
    pub(crate) fn new(path: Vec<PathBuf>, lock: bool) -> Result<Self, Error> {
        Ok(Self {
            graph: Graph::default(),
            counters: Counters { next_component: 1, next_thread: 1, ..Counters::default() },
            staged: Staged::default(),
            lock: Lock::NONE,
            rings: BTreeMap::new(),
            loader: Loader::new(path),
            questions: Vec::new(),
            departed: Vec::new(),
            arena: Arena::new(lock)?,
        })
    }

    /// Returns the graph.
    pub(crate) const fn graph(&self) -> &Graph {
        &self.graph
    }

    /// Returns the loader.
    pub(crate) const fn loader(&mut self) -> &mut Loader {
        &mut self.loader
    }

    /// Returns the memory of the values.
    pub(crate) const fn arena(&self) -> &Arena {
        &self.arena
    }

    /// Returns the transaction in progress.
    pub(crate) const fn staged(&self) -> &Staged {
        &self.staged
    }

    /// Returns the transaction in progress, to add a step.
    pub(crate) const fn staged_mut(&mut self) -> &mut Staged {
        &mut self.staged
    }

    /// Returns the locked operations.
    pub(crate) const fn lock(&self) -> Lock {
        self.lock
    }

    /// Locks operations.
    pub(crate) const fn set_lock(&mut self, lock: Lock) {
        self.lock = lock;
    }

    /// Returns an error if a bit of `lock` is set in the instance's lock.
    pub(crate) const fn unlocked(&self, lock: Lock, what: &'static str) -> Result<(), Error> {
        if self.lock.0 & lock.0 == 0 { Ok(()) } else { Err(Error::Locked { what }) }
    }

    /// Leaks everything that a thread still uses that never leaves its function.
    pub(crate) fn leak(&mut self) {
        let _left = core::mem::ManuallyDrop::new((
            core::mem::take(&mut self.graph),
            core::mem::take(&mut self.rings),
        ));
        self.arena.leave();
    }
}

/// Script positions.
impl Model {
    /// Sets the position for everything that is created from here on.
    pub(crate) fn stand(&mut self, file: &str, line: u32) {
        self.graph.sites.stand(file, line);
    }

    /// Sets the position for one request, or none if the client gave none. Returns the previous
    /// position, for [`Self::resume`].
    pub(crate) fn visit(&mut self, at: Option<&At>) -> Option<Site> {
        self.graph.sites.visit(at)
    }

    /// Restores the position that [`Self::visit`] returned.
    pub(crate) const fn resume(&mut self, before: Option<Site>) {
        self.graph.sites.resume(before);
    }

    /// Records that the machine has run. Values that are set afterwards are intended changes.
    pub(crate) const fn has_run(&mut self) {
        self.graph.sites.has_run();
    }
}

/// Declarations of a component.
impl Model {
    /// Remembers the name that an item has in machines of the old kind, for messages. Empty: the same.
    pub(crate) fn note_former(
        &mut self,
        what: &'static str,
        former: &str,
        now: &Name,
    ) -> Result<(), Error> {
        if !former.is_empty() && former != now.as_str() {
            self.graph.former.insert(Name::parse(what, former)?, now.clone());
        }
        Ok(())
    }

    /// Returns the number of a documentation text.
    pub(crate) fn doc(&mut self, text: &str) -> Doc {
        self.graph.docs.number(text)
    }

    /// Returns a component, to complete it.
    pub(crate) fn component_mut(&mut self, ix: Ix) -> Option<&mut Component> {
        self.graph.component_mut(ix)
    }

    /// Renames a component that is being loaded. Reverting removes it by its node, whatever its
    /// name is then.
    pub(crate) fn rename(&mut self, component: Ix, name: Name) -> Result<(), Error> {
        let old = self.graph.component(component).map(|c| c.name.clone());
        let Some(old) = old.filter(|old| *old != name) else { return Ok(()) };
        if self.graph.components.contains_key(&name) {
            return Err(Error::Duplicate { what: "component name", name: name.as_str().into() });
        }
        self.graph.components.remove(&old);
        self.graph.components.insert(name.clone(), component);
        if let Some(c) = self.graph.component_mut(component) {
            c.name = name;
        }
        Ok(())
    }

    /// Adds a function of a component.
    pub(crate) fn new_funct(&mut self, owner: Ix, funct: Funct) -> Ix {
        let name = funct.name.clone();
        let ix = self.graph.g.add_node(Node::Funct(Box::new(funct)));
        self.graph.g.add_edge(owner, ix, Edge::Owns);
        self.graph.add_name(Index::Functs, &name, ix);
        ix
    }

    /// Adds a command of a component.
    pub(crate) fn new_command(&mut self, owner: Ix, command: Command) {
        self.graph.commands.insert(command.name.clone(), owner);
        if let Some(c) = self.graph.component_mut(owner) {
            c.commands.push(command);
        }
    }

    /// Records a relation of a new component.
    pub(crate) fn connect(&mut self, from: Ix, to: Ix, edge: Edge) {
        self.graph.g.add_edge(from, to, edge);
    }

    /// Marks a function as one that takes hidden state that no function produces.
    pub(crate) fn takes_hidden_state(&mut self, funct: Ix) {
        if let Some(funct) = self.graph.funct_mut(funct) {
            funct.told = true;
        }
    }

    /// Marks a function as one that computes with floating-point numbers if it accesses some.
    pub(crate) fn note_floats(&mut self, funct: Ix) {
        let edges = self.graph.g.neighbors_undirected(funct);
        let floats = edges.filter_map(|ix| self.graph.item(ix)).any(|i| i.ty == Type::Float);
        if let Some(funct) = self.graph.funct_mut(funct).filter(|_| floats) {
            funct.fp = true;
        }
    }

    /// Lets a pointer of foreign code follow a new pin.
    pub(crate) fn set_pointer(&mut self, pin: Ix, pointer: Pointer) {
        self.staged.owns(pointer.0.addr().get());
        if let Some(item) = self.graph.item_mut(pin) {
            item.set_pointer(pointer);
        }
    }
}

/// Streams.
impl Model {
    /// Returns the rings of streams, by name.
    pub(crate) const fn rings(&self) -> &BTreeMap<Name, SharedRing> {
        &self.rings
    }

    /// Adds the ring of a stream.
    pub(crate) fn new_ring(&mut self, name: Name, ring: SharedRing) {
        self.rings.insert(name, ring);
    }

    /// Returns the ring of a stream.
    pub(crate) fn ring_mut(&mut self, name: &str) -> Option<&mut SharedRing> {
        self.rings.get_mut(name)
    }

    /// Returns the rings of all streams.
    pub(crate) fn rings_mut(&mut self) -> impl Iterator<Item = (&Name, &mut SharedRing)> {
        self.rings.iter_mut()
    }
}

/// Components that have left.
impl Model {
    /// Returns the components that are still to be freed.
    pub(crate) fn departed(&self) -> &[Ix] {
        &self.departed
    }

    /// Takes the components that are still to be freed.
    pub(crate) fn take_left(&mut self) -> Vec<Ix> {
        core::mem::take(&mut self.departed)
    }

    /// Adds components that are to be freed.
    pub(crate) fn has_left(&mut self, components: impl IntoIterator<Item = Ix>) {
        for ix in components {
            if !self.departed.contains(&ix) {
                self.departed.push(ix);
            }
        }
    }

    /// Removes a component that has been freed from the list of those to be freed.
    pub(crate) fn is_freed(&mut self, component: Ix) {
        self.departed.retain(|left| *left != component);
    }
}

//! Removal of components and signals: first from threads, signals and names, then from the graph.

use crate::{
    Error,
    change::staged::PendingRemoval,
    change::undo::Undo,
    graph::model::Model,
    graph::names::Index,
    graph::{Component, Ix, Node},
    name::Name,
};

impl Model {
    /// `unloadrt NAME`.
    pub(crate) fn unload(&mut self, name: &str) -> Result<(), Error> {
        let ix = self
            .graph
            .components
            .get(name)
            .copied()
            .ok_or_else(|| Error::NotLoaded { name: name.into() })?;
        let Some(c) = self.graph.component(ix) else { return Ok(()) };
        if !c.realtime || name.starts_with("__") {
            return Err(Error::NotRealtime { name: name.into() });
        }
        if let Some(user) = self.graph.users(ix).first().and_then(|u| self.graph.component(*u)) {
            let user = user.name.as_str().into();
            return Err(Error::InUseBy { name: name.into(), user });
        }
        for further in self.graph.further_loads(name) {
            self.unload(further.as_str())?;
        }
        self.detach(ix, true);
        Ok(())
    }

    /// `unloadrt all`: newest first.
    pub(crate) fn unload_all(&mut self) -> Result<(), Error> {
        while let Some(name) = self.newest() {
            self.unload(name.as_str())?;
        }
        Ok(())
    }

    /// Returns the realtime component that was loaded last.
    pub(crate) fn newest(&self) -> Option<Name> {
        let newest_first = self.graph.components_by_age().into_iter().rev();
        let mut components = newest_first.filter_map(|ix| self.graph.component(ix));
        let loaded = |c: &&Component| c.realtime && !c.name.as_str().starts_with("__");
        components.find(loaded).map(|c| c.name.clone())
    }

    /// Returns everything that a component created, and its threads' pseudo components.
    pub(crate) fn all_owned(&self, component: Ix) -> Vec<Ix> {
        let mut out = Vec::new();
        for ix in self.graph.owned(component) {
            if self.graph.component(ix).is_some() {
                out.extend(self.graph.owned(ix));
            }
            out.push(ix);
        }
        out
    }

    /// Removes a component from threads, signals and names; it is freed at the end of the
    /// transaction.
    pub(crate) fn detach(&mut self, component: Ix, stop: bool) {
        let owned = self.all_owned(component);
        self.unlink_all(&owned);
        for ix in &owned {
            if self.graph.funct(*ix).is_some() {
                for thread in self.graph.threads_of(*ix) {
                    self.take_out(*ix, thread);
                }
            }
            if self.graph.thread(*ix).is_some() {
                self.touch_thread(*ix);
                self.graph.empty_thread(*ix);
            }
        }
        for provider in self.graph.needed_by(component) {
            self.staged.undo_by(Undo::Released(component, provider));
        }
        let names: Vec<Name> =
            self.rings.iter().filter(|r| r.1.owner == component).map(|r| r.0.clone()).collect();
        for name in names {
            if let Some((name, ring)) = self.rings.remove_entry(&name) {
                self.staged.undo_by(Undo::Ring(name, Box::new(ring)));
            }
        }
        for ix in owned.into_iter().chain([component]) {
            self.unname_node(ix);
        }
        self.staged.remove(PendingRemoval::Component { ix: component, stop });
    }

    /// Removes a node's names.
    pub(crate) fn unname_node(&mut self, ix: Ix) {
        let (index, names) = match self.graph.g.node_weight(ix) {
            Some(Node::Item(item)) => {
                let param = !item.direction.is_pin();
                if self.graph.item_named(param, item.name.as_str()) == Some(ix) {
                    let count =
                        if param { &mut self.counters.params } else { &mut self.counters.pins };
                    *count -= 1;
                }
                let names = [Some(item.name.clone()), item.other().cloned(), item.alias().cloned()];
                (Index::of_items(param), names)
            }
            Some(Node::Funct(f)) => (Index::Functs, [Some(f.name.clone()), None, None]),
            Some(Node::Thread(t)) => (Index::Threads, [Some(t.name.clone()), None, None]),
            Some(Node::Component(c)) => {
                let commands: Vec<Name> = c.commands.iter().map(|c| c.name.clone()).collect();
                let name = c.name.clone();
                commands.iter().for_each(|c| self.unname(Index::Commands, c, ix));
                (Index::Components, [Some(name), None, None])
            }
            Some(Node::Signal(_)) | None => return,
        };
        names.iter().flatten().for_each(|name| self.unname(index, name, ix));
    }

    /// Returns the nodes that are removed at the end of the transaction.
    pub(crate) fn removed_nodes(&self) -> Vec<Ix> {
        let mut nodes = Vec::new();
        for pending_removal in self.staged.pending_removal() {
            match *pending_removal {
                PendingRemoval::Signal(ix) => nodes.push(ix),
                PendingRemoval::Component { ix, .. } => nodes.extend(self.all_owned(ix)),
            }
        }
        nodes
    }

    /// Frees a component and everything that it created. No thread, signal or name refers to it.
    /// Returns its number and name.
    pub(crate) fn free(&mut self, component: Ix) -> Option<(u32, Name)> {
        self.rings.retain(|_, r| r.owner != component);
        for ix in self.all_owned(component) {
            self.remove_node(ix);
        }
        let gone = self.graph.component(component).map(|c| (c.id, c.name.clone()));
        self.remove_node(component);
        gone
    }

    /// Prepares the graph for the removal of all components.
    pub(crate) fn before_all_are_freed(&mut self) {
        self.graph.forget_all_but_pins();
    }

    /// Frees a node that no thread, signal or name refers to.
    fn remove_node(&mut self, ix: Ix) {
        let graph = &mut self.graph;
        graph.sites.forget(ix);
        let Some(node) = graph.g.remove_node(ix) else { return };
        // Another node may have the name by now.
        let mut forget = |index, name: &Name| {
            graph.remove_name(index, name, ix);
        };
        match node {
            Node::Item(item) => {
                let index = Index::of_items(!item.direction.is_pin());
                let names = [Some(&item.name), item.other(), item.alias()];
                names.into_iter().flatten().for_each(|name| forget(index, name));
                if let Some(slot) = item.slot() {
                    self.arena.give_slot(slot);
                }
            }
            Node::Funct(f) => forget(Index::Functs, &f.name),
            Node::Thread(t) => forget(Index::Threads, &t.name),
            Node::Component(c) => {
                forget(Index::Components, &c.name);
                c.commands.iter().for_each(|command| forget(Index::Commands, &command.name));
            }
            Node::Signal(_) => {}
        }
    }

    /// Removes a signal that has no pins.
    pub(crate) fn forget_signal(&mut self, ix: Ix) {
        if let Some(Node::Signal(s)) = self.graph.g.remove_node(ix) {
            // Another signal may have this name by now.
            self.graph.remove_name(Index::Signals, &s.name, ix);
            self.graph.sites.forget(ix);
            self.arena.give_cell(s.cell.0);
            drop(s.queue);
        }
    }
}

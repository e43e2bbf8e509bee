//! `unloadrt`: removes a component from threads, signals and names, and frees it when nothing uses
//! it.

use crate::{
    Engine, Error,
    change::transaction::Going,
    change::undo::{Index, Undo},
    ends::{self, Doing, What},
    graph::{Component, Ix, Node},
    name::Name,
};

impl Engine {
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
    fn all_owned(&self, component: Ix) -> Vec<Ix> {
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
    fn detach(&mut self, component: Ix, stop: bool) {
        let owned = self.all_owned(component);
        self.part_probes(&owned);
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
        self.staged.going.push(Going::Component { ix: component, stop });
    }

    /// Removes a node's names.
    fn unname_node(&mut self, ix: Ix) {
        let (index, names) = match self.graph.g.node_weight(ix) {
            Some(Node::Item(item)) => {
                let param = !item.direction.is_pin();
                if self.graph.names(param).get(&item.name) == Some(&ix) {
                    let count = if param { &mut self.counts.params } else { &mut self.counts.pins };
                    *count -= 1;
                }
                let names = [Some(item.name.clone()), item.other.clone(), item.alias.clone()];
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

    /// Frees a thing that has been removed from threads, signals and names.
    pub(crate) fn release(&mut self, going: Going) {
        match going {
            Going::Signal(ix) => self.forget_signal(ix),
            Going::Component { ix, stop } => {
                let threads = self.end_own_threads(ix);
                if stop {
                    // A failed stop action does not keep the component loaded.
                    self.run_stops(&[ix]);
                }
                match threads {
                    Ok(()) => {
                        self.free_component(ix);
                        self.left.retain(|left| *left != ix);
                    }
                    // Freed later.
                    Err(e) => self.notice(e.to_string()),
                }
            }
        }
    }

    /// Frees a new component whose transaction is reverted. Returns false if one of its threads
    /// cannot be ended: the component is then freed after that thread has left its cycle.
    pub(crate) fn discard(&mut self, component: Ix) -> bool {
        if let Err(e) = self.end_own_threads(component) {
            self.notice(e.to_string());
            for ix in self.all_owned(component).into_iter().chain([component]) {
                self.unname_node(ix);
            }
            self.left.push(component);
            return false;
        }
        self.free_component(component);
        true
    }

    fn end_own_threads(&mut self, component: Ix) -> Result<(), Error> {
        let ticks = |ix: &Ix| {
            let thread = self.graph.thread(*ix);
            let all = self.shared.threads.load();
            thread.is_some_and(|t| all.iter().any(|a| a.id == t.thread.id))
        };
        let own: Vec<Ix> = self.all_owned(component).into_iter().filter(ticks).collect();
        if own.is_empty() { Ok(()) } else { self.end_threads(&own) }
    }

    /// Removes a component and everything it created, at the engine's own initiative.
    pub(crate) fn remove_component(&mut self, component: Ix) {
        if self.graph.component(component).is_none() {
            return;
        }
        let removed = self.whole(|engine| {
            engine.detach(component, false);
            Ok(())
        });
        if let Err(e) = removed {
            self.notice(e.to_string());
        }
    }

    /// Frees a component that no thread, signal or name refers to.
    fn free_component(&mut self, component: Ix) {
        let name = self.graph.component(component).map_or("?", |c| c.name.as_str());
        let instance = self.instance.clone();
        let _within = instance.control.run(Doing::new(name, What::Unload));
        if let Some(c) = self.graph.component(component)
            && c.origin.as_ref().is_some_and(|o| !o.threads.is_empty())
        {
            ends::note_own_threads(&c.name, false);
        }
        let owned = self.all_owned(component);
        // Its messages are static texts in its library, which may close with it.
        if let Some(id) = self.graph.component(component).map(|c| c.id) {
            self.hear_last_of(id);
        }
        self.tasks.retain(|t| t.owner != component);
        self.rings.retain(|_, r| r.owner != component);
        let gone: Vec<u64> =
            self.tickets.iter().filter(|(_, p)| p.owner == component).map(|(id, _)| *id).collect();
        for id in gone {
            self.tickets.remove(&id);
            let why = "its component was unloaded".to_owned();
            self.finished.insert(id, hal_protocol::TicketInfo::Failed(why));
        }
        for ix in owned {
            self.remove_node(ix);
        }
        self.gone = self.graph.component(component).map(|c| (c.id, c.name.clone()));
        self.remove_node(component);
        self.renew_remains();
    }

    fn remove_node(&mut self, ix: Ix) {
        let graph = &mut self.graph;
        graph.sites.forget(ix);
        let Some(node) = graph.g.remove_node(ix) else { return };
        // Another node may have the name by now.
        let mut forget = |index, name: &Name| {
            let names = graph.index_mut(index);
            if names.get(name) == Some(&ix) {
                names.remove(name);
            }
        };
        match node {
            Node::Item(item) => {
                let index = Index::of_items(!item.direction.is_pin());
                let names = [Some(&item.name), item.other.as_ref(), item.alias.as_ref()];
                names.into_iter().flatten().for_each(|name| forget(index, name));
                if let Some(slot) = item.slot() {
                    self.arena.give_slot(slot);
                }
            }
            Node::Funct(f) => {
                forget(Index::Functs, &f.name);
                self.forgive(&f.name);
            }
            Node::Thread(t) => forget(Index::Threads, &t.name),
            Node::Component(c) => {
                forget(Index::Components, &c.name);
                c.commands.iter().for_each(|command| forget(Index::Commands, &command.name));
            }
            Node::Signal(_) => {}
        }
    }
}

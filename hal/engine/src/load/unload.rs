//! Release of components that have been removed from threads, signals and names.

use crate::{
    Engine, Error,
    change::staged::PendingRemoval,
    change::stores::Change,
    ends::{self, Activity, Doing},
    graph::Ix,
    name::Name,
    sync::Arc,
};

impl Engine {
    /// Frees a thing that has been removed from threads, signals and names.
    pub(crate) fn release(&mut self, pending_removal: PendingRemoval) {
        match pending_removal {
            PendingRemoval::Signal(ix) => self.model.forget_signal(ix),
            PendingRemoval::Component { ix, stop } => {
                let threads = self.end_own_threads(ix);
                if stop {
                    // A failed stop action does not keep the component loaded.
                    self.run_stops(&[ix]);
                }
                match threads {
                    Ok(()) => {
                        self.free_component(ix);
                        self.model.is_freed(ix);
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
            for ix in self.model.all_owned(component).into_iter().chain([component]) {
                self.model.unname_node(ix);
            }
            self.model.has_left([component]);
            return false;
        }
        self.free_component(component);
        true
    }

    fn end_own_threads(&mut self, component: Ix) -> Result<(), Error> {
        let owned = self.model.all_owned(component);
        let threads = owned.iter().filter_map(|ix| self.model.graph().thread(*ix));
        let begun = threads.filter(|t| self.runtime.has_begun(&t.thread));
        let ids: Vec<u32> = begun.map(|t| t.thread.id).collect();
        if ids.is_empty() { Ok(()) } else { self.runtime.end_threads(&ids) }
    }

    /// Removes a component and everything it created, at the engine's own initiative.
    pub(crate) fn remove_component(&mut self, component: Ix) {
        if self.model.graph().component(component).is_none() {
            return;
        }
        let removed = self.transact(|engine| {
            engine.model.detach(component, false);
            Ok(())
        });
        if let Err(e) = removed {
            self.notice(e.to_string());
        }
    }

    /// Frees all components, the newest first, after every thread has ended. Nothing reads links and
    /// values any more, so no pin is unlinked first.
    pub(crate) fn free_all(&mut self) {
        let threads = self.model.graph().threads.values();
        let threads = threads.filter_map(|ix| self.model.graph().thread(*ix));
        let lists = threads.map(|t| (t.thread.clone(), Arc::default())).collect();
        if let Err(e) = self.runtime.commit(&Change { stores: Vec::new(), lists }) {
            self.notice(e.to_string());
        }
        self.reap();
        self.model.before_all_are_freed();
        for ix in self.model.graph().components_by_age().into_iter().rev() {
            // A thread's own component is freed with the one that created the thread.
            if self.model.graph().component(ix).is_none() {
                continue;
            }
            self.end_probes_of(ix);
            match self.end_own_threads(ix) {
                Ok(()) => self.free_component(ix),
                Err(e) => self.notice(e.to_string()),
            }
        }
        self.reap();
    }

    /// Frees a component that no thread, signal or name refers to.
    fn free_component(&mut self, component: Ix) {
        let name = self.model.graph().component(component).map_or("?", |c| c.name.as_str());
        let instance = self.runtime.instance().clone();
        let _within = instance.control.run(Doing::new(name, Activity::Unload));
        if let Some(c) = self.model.graph().component(component)
            && c.origin.as_ref().is_some_and(|o| !o.threads.is_empty())
        {
            ends::note_own_threads(&c.name, false);
        }
        let graph = self.model.graph();
        let functs = graph.owned(component).into_iter().filter_map(|ix| graph.funct(ix));
        let functs: Vec<Name> = functs.map(|f| f.name.clone()).collect();
        // Its messages are static texts in its library, which may close with it.
        if let Some(id) = graph.component(component).map(|c| c.id) {
            self.drain_messages();
            self.log.end_of(id);
        }
        self.runtime.remove_tasks(component);
        // The failure of a worker goes with it: the rest may be started again.
        for name in self.workers.free(component) {
            self.forgive(&name);
        }
        self.clients.fail_tickets(component, "its component was unloaded");
        functs.iter().for_each(|name| self.forgive(name));
        let gone = self.model.free(component);
        self.snapshots.free(component);
        self.log.has_gone(gone);
        self.renew_remains();
    }
}

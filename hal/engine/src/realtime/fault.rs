//! Stuck threads and failed functions, and the engine's reactions to them.

use crate::{
    Engine,
    ends::{self, Origin, Remains},
    graph::Ix,
    messages::text::of_panic,
    name::Name,
    realtime::thread::NOBODY,
    sync::Arc,
};
use hal_protocol::FaultInfo;
use std::collections::BTreeSet;

impl Engine {
    /// If a function has failed, waits for the threads to stop and drives outputs to their safe
    /// levels.
    pub(crate) fn notice_fault(&mut self) {
        let Some((thread, funct)) = self.runtime.shared().fault.get() else { return };
        if self.runtime.fault().is_some() {
            return;
        }
        self.runtime.shared().wait_for_cycles();
        self.run_stops(&self.model.graph().components_by_age());
        let info = if thread == NOBODY {
            self.worker_fault(funct)
        } else {
            self.function_fault(thread, funct)
        };
        let why = format!("fault: {} of {}: {}", info.funct, info.component, info.cause);
        self.flight_event(self.runtime.now(), &why);
        self.runtime.set_fault(info);
    }

    /// Reports the function that has failed.
    fn function_fault(&mut self, thread: u32, funct: u32) -> FaultInfo {
        let graph = self.model.graph();
        let thread = graph
            .threads
            .values()
            .filter_map(|ix| graph.thread(*ix))
            .find(|t| t.thread.id == thread)
            .map_or("?", |t| t.name.as_str());
        let owner = graph.owner(Ix::from(funct)).map_or("?", |c| c.name.as_str());
        let info = FaultInfo {
            component: owner.to_owned(),
            funct: graph.funct_name(funct),
            thread: thread.to_owned(),
            cause: of_panic(self.runtime.shared().fault.cause()),
        };
        self.notice(format!(
            "function '{}' of component '{}' failed in thread '{}': {}; all threads are stopped \
             and outputs are at their safe levels",
            info.funct, info.component, info.thread, info.cause
        ));
        info
    }

    /// Reports the worker that has failed.
    fn worker_fault(&mut self, id: u32) -> FaultInfo {
        let named = self.workers.named(id);
        let (owner, name) = named.map_or(("?", "?"), |(o, name)| (o.as_str(), name.as_str()));
        let info = FaultInfo {
            component: owner.to_owned(),
            funct: name.to_owned(),
            thread: String::new(),
            cause: of_panic(self.runtime.shared().fault.cause()),
        };
        self.notice(format!(
            "worker '{}' of component '{}' failed: {}; all threads are stopped and outputs are at \
             their safe levels",
            info.funct, info.component, info.cause
        ));
        info
    }

    /// Clears the fault after the failed function has been removed: the rest may be started again.
    pub(crate) fn forgive(&mut self, funct: &Name) {
        if self.runtime.fault().is_none_or(|f| f.funct != funct.as_str()) {
            return;
        }
        // If a thread is stuck, the next `start` tries again.
        if self.runtime.stop().is_ok() {
            self.runtime.clear_fault();
        }
    }

    /// Records the file that a component's code comes from.
    pub(crate) fn note_origin(&mut self, component: Ix, file: Option<Box<str>>) {
        if let (Some(c), Some(file)) = (self.model.component_mut(component), file) {
            c.origin = Some(Origin { file, component: c.name.clone(), threads: Vec::new() });
        }
        self.renew_remains();
    }

    /// Records the system threads that were started while a component was loaded as the component's
    /// own.
    pub(crate) fn note_threads(&mut self, component: Ix, before: &BTreeSet<i32>) {
        let new: Vec<i32> = ends::threads().difference(before).copied().collect();
        if before.is_empty() || new.is_empty() {
            return;
        }
        let Some(c) = self.model.component_mut(component) else { return };
        ends::note_own_threads(&c.name, true);
        c.origin.iter_mut().for_each(|o| o.threads.clone_from(&new));
        self.renew_remains();
    }

    /// Updates the stop actions and names that are used at the end of the process.
    pub(crate) fn renew_remains(&self) {
        let mut remains = Remains::default();
        for ix in self.model.graph().components_by_age() {
            let Some(c) = self.model.graph().component(ix) else { continue };
            remains.stops.extend(c.stops.iter().cloned());
            remains.origins.extend(c.origin.clone());
            remains.names.push((c.id, c.name.clone()));
        }
        self.runtime.shared().stops.store(Arc::new(remains.stops.clone()));
        self.runtime.instance().replace(remains);
    }

    /// Runs the stop actions of components.
    pub(crate) fn run_stops(&mut self, components: &[Ix]) {
        let failed = self.runtime.run_stops(self.model.graph(), components);
        self.notices(failed);
    }
}

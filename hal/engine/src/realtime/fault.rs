//! Stuck threads and failed functions, and the engine's reactions to them.

use crate::{
    Engine, Error,
    ends::{self, Doing, Origin, Remains, What},
    graph::{Ix, Node},
    name::Name,
    os,
    realtime::shared::Cause,
    sync::{Arc, Ordering},
};
use hal_protocol::FaultInfo;
use std::collections::BTreeSet;

impl Engine {
    /// Returns the error that names the thread that does not leave its cycle.
    pub(crate) fn stuck(&self) -> Error {
        let threads = self.shared.threads.load();
        if let Some(t) = threads.iter().find(|t| t.gate.is_inside()) {
            // Found by number: the thread's name may be about to be removed.
            let name = self.graph.g.node_weights().find_map(|n| match n {
                Node::Thread(node) if node.thread.id == t.id => Some(node.name.as_str()),
                _ => None,
            });
            let funct = self.funct_name(t.current.load(Ordering::Relaxed));
            return Error::Stuck { thread: name.unwrap_or("?").into(), funct: funct.into() };
        }
        Error::Stuck { thread: "?".into(), funct: "?".into() }
    }

    /// Returns the fault that stopped the threads, while its thread is still inside the function.
    pub(crate) fn stuck_still(&self) -> Option<FaultInfo> {
        let fault = self.fault.as_ref().filter(|_| self.shared.fault.is_abandoned())?;
        let (thread, _) = self.shared.fault.get()?;
        let threads = self.shared.threads.load();
        let is_inside = threads.iter().any(|t| t.id == thread && t.gate.is_inside());
        let cause = "it does not come back".to_owned();
        is_inside.then(|| FaultInfo { cause, ..fault.clone() })
    }

    /// Returns the name of a function by its number.
    pub(crate) fn funct_name(&self, id: u32) -> String {
        let funct = self.graph.funct(Ix::from(id));
        funct.map_or_else(|| "?".to_owned(), |f| f.name.as_str().to_owned())
    }

    /// If a function has failed, waits for the threads to stop and drives outputs to their safe
    /// levels.
    pub(crate) fn notice_fault(&mut self) {
        let Some((thread, funct)) = self.shared.fault.get() else { return };
        if self.fault.is_some() {
            return;
        }
        let threads = self.shared.threads.load_full();
        let slowest = threads.iter().map(|t| t.period_ns).max().unwrap_or(0);
        let limit = os::monotonic_ns() + slowest.saturating_mul(2);
        while threads.iter().any(|t| t.gate.is_inside()) && os::monotonic_ns() < limit {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        self.run_stops(&self.graph.components_by_age());
        let thread = self
            .graph
            .threads
            .values()
            .filter_map(|ix| self.graph.thread(*ix))
            .find(|t| t.thread.id == thread)
            .map_or("?", |t| t.name.as_str());
        let owner = self.graph.owner(Ix::from(funct)).map_or("?", |c| c.name.as_str());
        let info = FaultInfo {
            component: owner.to_owned(),
            funct: self.funct_name(funct),
            thread: thread.to_owned(),
            cause: said(self.shared.fault.cause()),
        };
        self.notice(format!(
            "function '{}' of component '{}' failed in thread '{}': {}; all threads are stopped \
             and outputs are at their safe levels",
            info.funct, info.component, info.thread, info.cause
        ));
        let why = format!("fault: {} of {}: {}", info.funct, info.component, info.cause);
        self.flight_event(self.shared.now(), &why);
        self.fault = Some(info);
    }

    /// Clears the fault after the failed function has been removed: the rest may be started again.
    pub(crate) fn forgive(&mut self, funct: &Name) {
        if self.fault.as_ref().is_none_or(|f| f.funct != funct.as_str()) {
            return;
        }
        self.shared.boundary.stop();
        // If a thread is stuck, the next `start` tries again.
        if self.settle().is_ok() {
            self.fault = None;
            self.shared.fault.clear();
        }
    }

    /// Records the file that a component's code comes from.
    pub(crate) fn note_origin(&mut self, component: Ix, file: Option<Box<str>>) {
        if let (Some(c), Some(file)) = (self.graph.component_mut(component), file) {
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
        let Some(c) = self.graph.component_mut(component) else { return };
        ends::note_own_threads(&c.name, true);
        c.origin.iter_mut().for_each(|o| o.threads.clone_from(&new));
        self.renew_remains();
    }

    /// Updates the stop actions and names that are used at the end of the process.
    pub(crate) fn renew_remains(&self) {
        let mut remains = Remains::default();
        for ix in self.graph.components_by_age() {
            let Some(c) = self.graph.component(ix) else { continue };
            remains.stops.extend(c.stops.iter().cloned());
            remains.origins.extend(c.origin.clone());
            remains.names.push((c.id, c.name.clone()));
        }
        self.shared.stops.store(Arc::new(remains.stops.clone()));
        self.instance.replace(remains);
    }

    /// Runs the stop actions of components.
    pub(crate) fn run_stops(&mut self, components: &[Ix]) {
        let mut failed = Vec::new();
        let shared = self.shared.clone();
        let alone = shared.stops_alone();
        for ix in components.iter().filter(|_| self.trial.is_none()) {
            let Some(c) = self.graph.component(*ix) else { continue };
            let _within = self.instance.control.run(Doing::new(c.name.as_str(), What::Stop));
            for stop in &c.stops {
                if let Err(e) = ends::run_stop(stop) {
                    failed.push(format!("{}: stop action: {e}", c.name));
                }
            }
        }
        drop(alone);
        failed.into_iter().for_each(|f| self.notice(f));
    }
}

/// Returns the text of a panic.
pub(crate) fn said(cause: &Cause) -> String {
    let (bytes, n) = cause.bytes();
    let text = String::from_utf8_lossy(bytes.get(..n).unwrap_or_default());
    // A longer text was cut, perhaps inside a character.
    let whole = n < bytes.len();
    if whole { text.into_owned() } else { format!("{}…", text.trim_end_matches('\u{fffd}')) }
}

//! Start and end of probes, and their places in the lists of threads.

use crate::{
    Engine, Error,
    change::stores::Change,
    graph::{Ix, Storage},
    observe::probe::Source,
    observe::probes::{At, Watching},
    realtime::thread::List,
    sync::Arc,
};
use std::collections::BTreeSet;

impl Engine {
    /// Returns the location of the value of a pin, parameter or signal.
    pub(crate) fn source(&self, ix: Ix) -> Option<Source> {
        if let Some(signal) = self.model.graph().signal(ix) {
            return Some(Source::Cell(signal.cell));
        }
        let item = self.model.graph().item(ix)?;
        Some(match item.storage() {
            Storage::Slot(slot) => Source::Slot(slot),
            Storage::Own(place) => Source::own(place, item.ty),
        })
    }

    /// Starts a probe and returns its number.
    pub(crate) fn begin_watching(&mut self, watching: Watching) -> Result<u64, Error> {
        self.swap_watching(None, watching)
    }

    /// Starts a probe in place of another that reads at the same times, so that no reading is
    /// missed.
    pub(crate) fn swap_watching(
        &mut self,
        old: Option<u64>,
        watching: Watching,
    ) -> Result<u64, Error> {
        let at = watching.at;
        let (id, before) = self.observers.probes.swap(old, watching);
        let done = self.renew_probes(at);
        if done.is_err() {
            self.observers.probes.swap_back(id, before);
        }
        done.map(|()| id)
    }

    /// Ends a probe. A stuck thread may still have it in its list, which keeps it alive.
    pub(crate) fn end_watching(&mut self, id: u64) {
        let Some(ended) = self.observers.probes.remove(id) else { return };
        if let Err(e) = self.renew_probes(ended.at)
            && self.runtime.waits()
        {
            self.notice(e.to_string());
        }
    }

    /// Rebuilds the list of the thread that runs probes of this kind.
    fn renew_probes(&mut self, at: At) -> Result<(), Error> {
        let thread = match at {
            At::Thread(ix) => Some(ix),
            At::Moments => self.moments_thread(),
        };
        let Some(ix) = thread else { return Ok(()) };
        let Some(thread) = self.model.graph().thread(ix).map(|t| t.thread.clone()) else {
            return Ok(());
        };
        let list = Arc::new(self.list_of(ix));
        self.runtime.commit(&Change { stores: Vec::new(), lists: vec![(thread, list)] })
    }

    /// Returns the thread that reads at instants: on the real clock, the fastest.
    fn moments_thread(&self) -> Option<Ix> {
        if self.runtime.is_virtual() {
            return None;
        }
        let first = self.runtime.shared().threads.load().first()?.id;
        let is_first =
            |ix: &Ix| self.model.graph().thread(*ix).is_some_and(|t| t.thread.id == first);
        self.model.graph().threads.values().copied().find(is_first)
    }

    /// Moves the probes to the fastest thread if that has changed.
    pub(crate) fn follow_fastest(&mut self) -> Result<(), Error> {
        let Some(ix) = self.moments_thread() else { return Ok(()) };
        let has =
            self.model.graph().thread(ix).map_or(0, |t| t.thread.list.load().idle_probes.len());
        if has == self.observers.probes.idle_probes().len() {
            Ok(())
        } else {
            self.renew_probes(At::Moments)
        }
    }

    /// Returns the list that a thread has to run: its functions and probes, without those that end
    /// with the staged changes.
    pub(crate) fn list_of(&self, thread: Ix) -> List {
        let idle_probes = self.moments_thread() == Some(thread);
        let parts = |id| self.model.staged().parts(id);
        self.observers.probes.add_to(thread, idle_probes, parts, self.model.list_of(thread))
    }

    /// Marks every probe for removal that watches one of these nodes or runs in one of these
    /// threads, which are about to be removed.
    pub(crate) fn end_probes(&mut self, nodes: &[Ix]) {
        for (id, at) in self.observers.probes.watching(nodes) {
            self.model.staged_mut().end_probe(id);
            let thread = match at {
                At::Thread(ix) => Some(ix),
                At::Moments => self.moments_thread(),
            };
            if let Some(thread) = thread {
                self.model.touch_thread(thread);
            }
        }
    }

    /// On the real clock, reads the values from the control side while no cycle runs.
    pub(crate) fn look_while_stopped(&self, now: i64) {
        if self.runtime.is_quiet() && !self.runtime.is_running() {
            self.observers.probes.idle_probes().iter().for_each(|p| p.sample(now));
        }
    }

    /// Ends the probes that watch a component's items, and informs their readers.
    pub(crate) fn end_probes_of(&mut self, component: Ix) {
        let owned = self.model.all_owned(component);
        let watching = self.observers.probes.watching(&owned);
        self.remove_probes(watching.into_iter().map(|(id, _)| id).collect());
    }

    /// Ends the probes whose items have been removed.
    pub(crate) fn remove_probes(&mut self, parted: BTreeSet<u64>) {
        for id in parted {
            self.observers.probes.remove(id);
            self.sample_parted(id);
            self.recording_parted(id);
        }
    }
}

//! The probes of an instance: their values, their times, their start and end.

use crate::{
    Engine, Error,
    change::stores::Change,
    graph::{Ix, Storage},
    observe::probe::{Probe, Source},
    realtime::thread::List,
    sync::Arc,
};
use std::collections::{BTreeMap, BTreeSet};

/// Time at which a probe reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum At {
    /// After the cycles of a thread.
    Thread(Ix),
    /// After everything that runs at one instant; on the real clock, after each cycle of the
    /// fastest thread.
    Moments,
}

/// An active probe.
#[derive(Debug)]
pub(crate) struct Watching {
    pub(crate) probe: Arc<Probe>,
    pub(crate) at: At,
    /// The nodes whose values it reads.
    pub(crate) nodes: BTreeSet<Ix>,
    /// True if the virtual clock must wait rather than lose something.
    pub(crate) lossless: bool,
}

/// All active probes.
#[derive(Debug, Default)]
pub(crate) struct Probes {
    all: BTreeMap<u64, Watching>,
    next: u64,
    /// The probes that read at instants.
    pub(crate) moments: Vec<Arc<Probe>>,
    /// The probes for which the virtual clock waits.
    pub(crate) lossless: Vec<Arc<Probe>>,
}

impl Probes {
    /// Returns whether the virtual clock can move without loss.
    pub(crate) fn have_room(&self) -> bool {
        self.lossless.iter().all(|p| p.has_room())
    }

    /// Returns whether the virtual clock waits for this probe.
    pub(crate) fn is_lossless(&self, id: u64) -> bool {
        self.all.get(&id).is_some_and(|w| w.lossless)
    }

    /// Lets the virtual clock move even if this probe has no room.
    pub(crate) fn lose(&mut self, id: u64) {
        if let Some(w) = self.all.get_mut(&id) {
            w.lossless = false;
        }
        self.sort();
    }

    fn sort(&mut self) {
        let chosen = |wanted: &dyn Fn(&&Watching) -> bool| {
            self.all.values().filter(wanted).map(|w| w.probe.clone()).collect()
        };
        let moments = chosen(&|w| w.at == At::Moments);
        let lossless = chosen(&|w| w.lossless);
        (self.moments, self.lossless) = (moments, lossless);
    }
}

impl Engine {
    /// Returns the location of the value of a pin, parameter or signal.
    pub(crate) fn source(&self, ix: Ix) -> Option<Source> {
        if let Some(signal) = self.graph.signal(ix) {
            return Some(Source::Cell(signal.cell));
        }
        let item = self.graph.item(ix)?;
        Some(match item.storage {
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
        self.probes.next += 1;
        let id = self.probes.next;
        let before = old.and_then(|old| Some((old, self.probes.all.remove(&old)?)));
        self.probes.all.insert(id, watching);
        self.probes.sort();
        let done = self.renew_probes(at);
        if done.is_err() {
            self.probes.all.remove(&id);
            self.probes.all.extend(before);
            self.probes.sort();
        }
        done.map(|()| id)
    }

    /// Ends a probe. A stuck thread may still have it in its list, which keeps it alive.
    pub(crate) fn end_watching(&mut self, id: u64) {
        let Some(ended) = self.probes.all.remove(&id) else { return };
        self.probes.sort();
        if let Err(e) = self.renew_probes(ended.at)
            && self.settle_ns > 0
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
        let Some(thread) = self.graph.thread(ix).map(|t| t.thread.clone()) else { return Ok(()) };
        let list = Arc::new(self.list_of(ix));
        self.carry_out(&Change { stores: Vec::new(), lists: vec![(thread, list)] })
    }

    /// Returns the thread that reads at instants: on the real clock, the fastest.
    fn moments_thread(&self) -> Option<Ix> {
        if self.shared.is_virtual() {
            return None;
        }
        let first = self.shared.threads.load().first()?.id;
        let is_first = |ix: &Ix| self.graph.thread(*ix).is_some_and(|t| t.thread.id == first);
        self.graph.threads.values().copied().find(is_first)
    }

    /// Moves the probes to the fastest thread if that has changed.
    pub(crate) fn follow_fastest(&mut self) -> Result<(), Error> {
        let Some(ix) = self.moments_thread() else { return Ok(()) };
        let has = self.graph.thread(ix).map_or(0, |t| t.thread.list.load().moments.len());
        if has == self.probes.moments.len() { Ok(()) } else { self.renew_probes(At::Moments) }
    }

    /// Returns the list with the probes of its thread, without those that end with the staged
    /// changes.
    pub(crate) fn with_probes(&self, thread: Ix, list: List) -> List {
        let stays = |(id, _): &(&u64, &Watching)| !self.staged.parting.contains(*id);
        let staying = self.probes.all.iter().filter(stays);
        let of = |at: At| staying.clone().filter(move |w| w.1.at == at).map(|w| w.1.probe.clone());
        let moments = self.moments_thread() == Some(thread);
        List {
            probes: of(At::Thread(thread)).collect(),
            moments: if moments { of(At::Moments).collect() } else { Vec::new() },
            ..list
        }
    }

    /// Marks every probe for removal that watches one of these nodes or runs in one of these
    /// threads, which are about to be removed.
    pub(crate) fn part_probes(&mut self, nodes: &[Ix]) {
        let watches =
            |w: &Watching| nodes.iter().any(|ix| w.nodes.contains(ix) || w.at == At::Thread(*ix));
        let parting: Vec<(u64, At)> =
            self.probes.all.iter().filter(|(_, w)| watches(w)).map(|(id, w)| (*id, w.at)).collect();
        for (id, at) in parting {
            self.staged.parting.insert(id);
            let thread = match at {
                At::Thread(ix) => Some(ix),
                At::Moments => self.moments_thread(),
            };
            if let Some(thread) = thread {
                self.touch_thread(thread);
            }
        }
    }

    /// On the real clock, reads the values from the control side while no cycle runs.
    pub(crate) fn look_while_stopped(&self, now: i64) {
        if self.quiet && !self.shared.boundary.is_running() {
            self.probes.moments.iter().for_each(|p| p.look(now));
        }
    }

    /// Ends the probes whose items have been removed.
    pub(crate) fn have_parted(&mut self, parted: BTreeSet<u64>) {
        for id in parted {
            self.probes.all.remove(&id);
            self.probes.sort();
            self.sample_parted(id);
            self.recording_parted(id);
        }
    }
}

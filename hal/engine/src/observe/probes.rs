//! The active probes of an instance: what each reads, and when.

use crate::{graph::Ix, observe::probe::Probe, realtime::thread::List, sync::Arc};
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
    idle_probes: Vec<Arc<Probe>>,
    /// The probes for which the virtual clock waits.
    lossless: Vec<Arc<Probe>>,
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

    /// Returns the probes that read at instants.
    pub(crate) fn idle_probes(&self) -> &[Arc<Probe>] {
        &self.idle_probes
    }

    /// Adds a probe in place of another, if there is one. Returns its number and the other.
    pub(super) fn swap(
        &mut self,
        old: Option<u64>,
        new: Watching,
    ) -> (u64, Option<(u64, Watching)>) {
        self.next += 1;
        let before = old.and_then(|old| Some((old, self.all.remove(&old)?)));
        self.all.insert(self.next, new);
        self.sort();
        (self.next, before)
    }

    /// Reverts [`Self::swap`].
    pub(super) fn swap_back(&mut self, new: u64, before: Option<(u64, Watching)>) {
        self.all.remove(&new);
        self.all.extend(before);
        self.sort();
    }

    /// Removes a probe.
    pub(super) fn remove(&mut self, id: u64) -> Option<Watching> {
        let removed = self.all.remove(&id);
        self.sort();
        removed
    }

    /// Returns the probes that watch one of these nodes or run in one of these threads.
    pub(super) fn watching(&self, nodes: &[Ix]) -> Vec<(u64, At)> {
        let watches =
            |w: &Watching| nodes.iter().any(|ix| w.nodes.contains(ix) || w.at == At::Thread(*ix));
        self.all.iter().filter(|(_, w)| watches(w)).map(|(id, w)| (*id, w.at)).collect()
    }

    /// Adds the probes of a thread to its functions, but for those that part. `idle_probes` says that
    /// the thread also reads at instants.
    pub(super) fn add_to(
        &self,
        thread: Ix,
        idle_probes: bool,
        parts: impl Fn(u64) -> bool,
        list: List,
    ) -> List {
        let staying = self.all.iter().filter(|(id, _)| !parts(**id));
        let of = |at: At| staying.clone().filter(move |w| w.1.at == at).map(|w| w.1.probe.clone());
        List {
            probes: of(At::Thread(thread)).collect(),
            idle_probes: if idle_probes { of(At::Moments).collect() } else { Vec::new() },
            ..list
        }
    }

    fn sort(&mut self) {
        let chosen = |wanted: &dyn Fn(&&Watching) -> bool| {
            self.all.values().filter(wanted).map(|w| w.probe.clone()).collect()
        };
        let idle_probes = chosen(&|w| w.at == At::Moments);
        let lossless = chosen(&|w| w.lossless);
        (self.idle_probes, self.lossless) = (idle_probes, lossless);
    }
}

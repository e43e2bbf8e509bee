//! The flight recorder: it holds the latest changes of all pins and signals in memory, and keeps
//! them when an event occurs.

mod condition;
mod history;
mod input;
mod keep;
mod recorder;

use crate::{
    Engine, Error,
    error::watch::WatchError,
    graph::{Item, Ix, Storage},
    name::Name,
    observe::probe::Probe,
    observe::probes::{At, Watching},
    sync::{Arc, AtomicU64},
};
use condition::Condition;
use hal_protocol::{FlightInfo, FlightSpec, KeptState, Type};
use history::{Group, History};
use keep::{Snapshot, create, format_of};
pub(crate) use recorder::Flight;

use std::{
    collections::{BTreeMap, VecDeque},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// Default size of the memory for changes, in bytes.
const DEFAULT_BYTES: u64 = 16 << 20;
/// Permitted sizes of that memory, in bytes.
const BYTES: core::ops::RangeInclusive<u64> = 1 << 12..=1 << 32;
/// Minimum capacity of the queue of changes.
const MIN_QUEUE: usize = 1 << 16;
impl Engine {
    /// Executes `flight on`. A recorder that is already on is replaced.
    pub(crate) fn begin_flight(&mut self, mut spec: FlightSpec) -> Result<(), Error> {
        if spec.bytes == 0 {
            spec.bytes = DEFAULT_BYTES;
        }
        if !BYTES.contains(&spec.bytes) {
            return Err(WatchError::FlightSize { bytes: spec.bytes }.into());
        }
        if let Some(file) = &spec.file {
            format_of(file)?;
        }
        let type_of = |name: &str| {
            let ix = self.watchable(name)?;
            let item = self.model.graph().item(ix);
            let ty = item.map(|i| i.ty).or_else(|| self.model.graph().signal(ix).map(|s| s.ty));
            ty.filter(|t| *t != Type::Port)
                .ok_or_else(|| WatchError::Port { name: name.into() }.into())
        };
        let own: Result<Vec<Condition>, Error> =
            spec.when.iter().map(|text| Condition::check(text, type_of)).collect();
        let conditions = own?;
        if self.observers.flight.is_some() {
            self.end_flight()?;
        }
        let flight = Arc::new(Mutex::new(Flight {
            history: History::new(spec.bytes, self.runtime.now()),
            spec,
            probe: None,
            columns: BTreeMap::new(),
            stale: true,
            conditions,
            by_column: BTreeMap::new(),
            open: None,
            awaited: None,
            events: 0,
            kept: VecDeque::new(),
            last: None,
            at_once: self.runtime.is_virtual(),
            ends: false,
            unwritten: false,
            said: Vec::new(),
            lost: (0, 0),
            lost_at: i64::MIN,
            lost_told: 0,
        }));
        self.runtime.instance().set_flight(Some(flight.clone()));
        self.observers.flight = Some(flight);
        self.refresh_flight();
        Ok(())
    }

    /// Executes `flight off`. An event in progress is kept first.
    pub(crate) fn end_flight(&mut self) -> Result<(), Error> {
        self.drain_flight();
        let kept = self.observers.flight.take().ok_or(WatchError::FlightOff)?;
        let mut flight = lock(&kept);
        if let Some((id, _, _)) = &flight.probe {
            self.end_watching(*id);
        }
        let now = self.runtime.now();
        flight.judge();
        flight.at_once = true;
        flight.ends = true;
        flight.finish(now);
        flight.look(true);
        self.observers.unwritten |= flight.unwritten;
        core::mem::take(&mut flight.said).into_iter().for_each(|text| self.notice(text));
        drop(flight);
        // Until its files are complete, the guard must know of it: a write may not return.
        self.runtime.instance().set_flight(None);
        Ok(())
    }

    /// Returns the state of the recorder.
    pub(crate) fn flight_info(&mut self) -> Result<FlightInfo, Error> {
        self.drain_flight();
        let to = self.runtime.now();
        let f = lock(self.observers.flight.as_ref().ok_or(WatchError::FlightOff)?);
        let values = f.probe.as_ref().map_or(0, |p| p.2.len());
        Ok(FlightInfo {
            bytes: f.spec.bytes,
            used: f.history.bytes(),
            values: u32::try_from(values).unwrap_or(u32::MAX),
            from: f.history.from(),
            to,
            lost: f.lost.0 + f.lost.1,
            kept: f.kept.iter().map(|k| k.info.clone()).chain(f.awaits()).collect(),
        })
    }

    /// Executes `flight save`, for the present contents or the last event.
    pub(crate) fn save_flight(&mut self, path: &str, last: bool) -> Result<(), Error> {
        let now = self.runtime.now();
        if let Some(flight) = self.observers.flight.as_deref().map(lock)
            && let Some((_, probe, _)) = &flight.probe
            && self.runtime.is_virtual()
        {
            // A script may have changed values while time stood still.
            probe.sample(now);
        }
        self.drain_flight();
        let at_once = self.runtime.is_virtual();
        let mut f = lock(self.observers.flight.as_ref().ok_or(WatchError::FlightOff)?);
        let snapshot = if last {
            f.last.clone().ok_or(WatchError::NoEvent)?
        } else {
            Arc::new(Snapshot { history: f.history.clone(), to: now, marks: Vec::new() })
        };
        let format = format_of(path)?;
        let file = create(path)?;
        let why = if last { "the last event, on request" } else { "asked for" };
        let mut kept = f.new_kept(now, why, Some(path.to_owned()), false);
        kept.write(&snapshot, file, format, at_once);
        f.keep(kept);
        match f.kept.back().map(|k| &k.info.state) {
            Some(KeptState::Failed(why)) => {
                Err(Error::File { path: path.into(), why: why.as_str().into() })
            }
            _ => Ok(()),
        }
    }

    /// Records an event that the engine has detected.
    pub(crate) fn flight_event(&mut self, time: i64, why: &str) {
        self.drain_flight();
        if let Some(f) = &self.observers.flight {
            lock(f).event(time, why);
        }
    }

    /// Notes that the set of watched values may have changed.
    pub(crate) fn flight_is_stale(&mut self) {
        if let Some(f) = &self.observers.flight {
            lock(f).stale = true;
        }
    }

    /// Updates the set of watched values.
    pub(crate) fn refresh_flight(&mut self) {
        let Some(flight) = self.observers.flight.clone() else { return };
        let mut flight = lock(&flight);
        if !core::mem::take(&mut flight.stale) {
            return;
        }
        let (nodes, groups) = self.groups(&flight);
        let sources: Box<[_]> = nodes.iter().filter_map(|ix| self.source(*ix)).collect();
        let last = sources.iter().map(|_| AtomicU64::new(0)).collect();
        let room = MIN_QUEUE.max(sources.len() * 4);
        let probe = Arc::new(Probe::changes(sources, last, room));
        // The first sample reports every value, so nothing is missed between the old probe and the
        // new one.
        probe.resync();
        let watching = Watching {
            probe: probe.clone(),
            at: At::Moments,
            // Values in the arena never move, so they may be watched until the next refresh even
            // after their removal.
            nodes: nodes.iter().copied().filter(|ix| self.is_own(*ix)).collect(),
            lossless: true,
        };
        let old = flight.probe.take();
        match self.swap_watching(old.as_ref().map(|o| o.0), watching) {
            Ok(id) => {
                if let Some((_, old, columns)) = &old {
                    flight.read_changes(old, columns, true);
                    flight.lost.0 += old.lost();
                    flight.lost.1 = 0;
                }
                let now = self.runtime.now();
                let columns = flight.history.regroup(now, &groups);
                flight.columns = nodes.into_iter().zip(columns.iter().copied()).collect();
                flight.probe = Some((id, probe, columns));
                flight.look_out(now);
            }
            Err(e) => {
                flight.probe = old;
                flight.stale = true;
                self.notice(e.to_string());
            }
        }
    }

    /// Returns whether a value lies in its component's own memory, which is freed with the
    /// component.
    fn is_own(&self, ix: Ix) -> bool {
        self.model.graph().item(ix).is_some_and(|i| matches!(i.storage(), Storage::Own(_)))
    }

    /// Returns signals with their pins, unlinked pins, and parameters that a condition names.
    fn groups(&self, flight: &Flight) -> (Vec<Ix>, Vec<Group>) {
        let mut nodes = Vec::new();
        let mut groups: Vec<Group> = Vec::new();
        // Group of each signal and pin.
        let mut group_of = BTreeMap::new();
        let before = |ix: &Ix| flight.columns.get(ix).copied();
        for (name, ix) in &self.model.graph().signal_names() {
            let Some(s) = self.model.graph().signal(*ix).filter(|s| s.ty != Type::Port) else {
                continue;
            };
            group_of.insert(*ix, groups.len());
            nodes.push(*ix);
            let names = vec![name.as_str().to_owned()];
            groups.push(Group { ty: s.ty, names, before: before(ix) });
        }
        let named = |name: &Name| flight.conditions.iter().any(|c| c.names(name.as_str()));
        let params = self.model.graph().item_names(true);
        let params = params.into_iter().filter(|(name, _)| named(name));
        for (name, ix) in self.model.graph().item_names(false).into_iter().chain(params) {
            // A value that a condition names is watched under any of its names.
            let wanted = |i: &&Item| {
                let plain = !i.hidden() && !i.times && i.shown() == name;
                i.ty != Type::Port && (plain || named(name))
            };
            let Some(item) = self.model.graph().item(ix).filter(wanted) else { continue };
            let place = self.model.graph().signal_of(ix).unwrap_or(ix);
            if let Some(group) = group_of.get(&place).and_then(|i: &usize| groups.get_mut(*i)) {
                group.names.push(name.as_str().to_owned());
                continue;
            }
            group_of.insert(place, groups.len());
            nodes.push(ix);
            let names = vec![name.as_str().to_owned()];
            groups.push(Group { ty: item.ty, names, before: before(&ix) });
        }
        (nodes, groups)
    }

    /// Reads queued changes, and keeps an event whose time of recording is over.
    pub(crate) fn drain_flight(&mut self) {
        // While no cycle is in progress, neither is a sample.
        let whole = self.runtime.is_virtual() || !self.runtime.is_running();
        let Some(flight) = self.observers.flight.clone() else { return };
        let mut flight = lock(&flight);
        if let Some((id, probe, columns)) = flight.probe.take() {
            flight.read_changes(&probe, &columns, whole);
            if probe.lost() != flight.lost.1 {
                // Recorded values are out of date, so all are reported again.
                flight.lost.1 = probe.lost();
                flight.lost_at = self.runtime.now();
                probe.resync();
            }
            flight.probe = Some((id, probe, columns));
        }
        let now = self.runtime.now();
        if flight.awaited.as_ref().is_some_and(|a| a.until <= now) {
            flight.finish(now);
        }
        flight.look(false);
        self.observers.unwritten |= flight.unwritten;
        core::mem::take(&mut flight.said).into_iter().for_each(|text| self.notice(text));
    }
}

/// Locks the recorder, which the guard also uses when the process crashes.
fn lock(flight: &Mutex<Flight>) -> MutexGuard<'_, Flight> {
    flight.lock().unwrap_or_else(PoisonError::into_inner)
}

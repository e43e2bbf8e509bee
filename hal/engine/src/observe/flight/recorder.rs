//! The state of the flight recorder, and how it keeps an event.

use super::{
    condition::Condition,
    history::History,
    keep::{Kept, Snapshot, create, format_of, numbered},
};
use crate::{graph::Ix, observe::probe::Probe, sync::Arc};
use hal_protocol::{FlightSpec, KeptInfo, KeptState};
use std::collections::{BTreeMap, VecDeque};

/// Maximum number of events in the list, and of events that are written to files.
const TOLD: usize = 20;
const MAX_FILES: u32 = 100;

/// Event whose time of recording is not over yet.
#[derive(Debug)]
pub(super) struct Awaited {
    pub(super) at: i64,
    pub(super) until: i64,
    pub(super) marks: Vec<(i64, String)>,
}

/// Flight recorder.
#[derive(Debug)]
pub(crate) struct Flight {
    pub(super) spec: FlightSpec,
    pub(super) history: History,
    /// Number of its probe, the probe, and the columns that it watches.
    pub(super) probe: Option<(u64, Arc<Probe>, Vec<u32>)>,
    /// Column of each signal and of each unlinked pin.
    pub(super) columns: BTreeMap<Ix, u32>,
    /// True if the set of watched values may have changed.
    pub(crate) stale: bool,
    pub(super) conditions: Vec<Condition>,
    /// Indices of the conditions that depend on a column.
    pub(super) by_column: BTreeMap<u32, Vec<usize>>,
    /// Sample that is not evaluated yet: its time, and the probe's number of samples then.
    pub(super) open: Option<(i64, u64)>,
    pub(super) awaited: Option<Awaited>,
    pub(super) events: u32,
    pub(super) kept: VecDeque<Kept>,
    pub(super) last: Option<Arc<Snapshot>>,
    /// True if files are written before time moves on.
    pub(super) at_once: bool,
    /// True if the recorder is being switched off, after which nothing stays in memory.
    pub(super) ends: bool,
    /// True if the file of an event could not be written.
    pub(super) unwritten: bool,
    /// Messages that are not yet reported.
    pub(super) said: Vec<String>,
    /// Number of changes lost by former probes, and by the present one as far as known.
    pub(super) lost: (u64, u64),
    /// Time at which the latest loss was noticed, and the number of lost changes at the latest event.
    pub(super) lost_at: i64,
    pub(super) lost_told: u64,
}

impl Flight {
    pub(super) fn event(&mut self, time: i64, why: &str) {
        let mark = (time, format!("trigger: {why}"));
        if let Some(awaited) = &mut self.awaited {
            awaited.marks.push(mark);
            return;
        }
        let until = time.saturating_add(i64::try_from(self.spec.after_ns).unwrap_or(i64::MAX));
        self.awaited = Some(Awaited { at: time, until, marks: vec![mark] });
    }

    /// Checks which files have been written; waits for them if `wait`.
    pub(super) fn look(&mut self, wait: bool) {
        let ends = self.ends;
        for k in &mut self.kept {
            if k.look(wait) {
                self.unwritten |= k.is_unwritten();
                self.said.push(k.words(ends));
            }
        }
    }

    /// Keeps the event in progress.
    pub(super) fn finish(&mut self, now: i64) {
        let Some(Awaited { at, until: end, marks }) = self.awaited.take() else { return };
        let mut history = self.history.clone();
        if let Some(before) = self.spec.before_ns {
            history.keep_from(at.saturating_sub(i64::try_from(before).unwrap_or(i64::MAX)));
        }
        let why = marks.first().map_or("", |m| m.1.trim_start_matches("trigger: ")).to_owned();
        let snapshot = Arc::new(Snapshot { history, to: end.min(now), marks });
        self.last = Some(snapshot.clone());
        self.events += 1;
        let wanted = self.spec.file.clone().filter(|_| self.events <= MAX_FILES);
        let file = wanted.map(|f| numbered(&f, self.events));
        let mut kept = self.new_kept(at, &why, file.clone(), true);
        kept.lost = self.lost_since_event(snapshot.history.from());
        if let Some(path) = &file {
            match (format_of(path), create(path)) {
                (Ok(format), Ok(file)) => kept.write(&snapshot, file, format, self.at_once),
                (Err(e), _) | (_, Err(e)) => {
                    let text = e.to_string();
                    let why = text.strip_prefix(&format!("{path}: ")).unwrap_or(&text).to_owned();
                    kept.info.state = KeptState::Failed(why);
                }
            }
        }
        if kept.info.state != KeptState::Writing {
            self.unwritten |= kept.is_unwritten();
            self.said.push(kept.words(self.ends));
        }
        self.keep(kept);
    }

    /// Returns the number of changes lost since the latest event, if any of them belongs to the time from `from` on.
    fn lost_since_event(&mut self, from: i64) -> u64 {
        let of_probe = self.probe.as_ref().map_or(self.lost.1, |p| p.1.lost());
        // While the probe is being read, its count is the one that the last reading found: an event
        // kept since then may have counted more.
        let all = (self.lost.0 + of_probe).max(self.lost_told);
        let lost = all - core::mem::replace(&mut self.lost_told, all);
        let is_recent = of_probe != self.lost.1 || from <= self.lost_at;
        if is_recent { lost } else { 0 }
    }

    /// Returns the event in progress.
    pub(super) fn awaits(&self) -> Option<KeptInfo> {
        let Awaited { at, marks, .. } = self.awaited.as_ref()?;
        let why = marks.first().map_or("", |m| m.1.trim_start_matches("trigger: ")).to_owned();
        let (number, state) = (self.events + 1, KeptState::Awaited);
        Some(KeptInfo { number, time: *at, why, file: None, state })
    }

    pub(super) fn new_kept(
        &self,
        time: i64,
        why: &str,
        file: Option<String>,
        is_event: bool,
    ) -> Kept {
        let (number, state) = (self.events, KeptState::InMemory);
        Kept::new(KeptInfo { number, time, why: why.to_owned(), file, state }, is_event)
    }

    pub(super) fn keep(&mut self, kept: Kept) {
        if self.kept.len() >= TOLD {
            self.kept.pop_front();
        }
        self.kept.push_back(kept);
    }
}

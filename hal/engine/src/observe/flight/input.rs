//! Input of the flight recorder: it reads changes sample by sample and detects events.

use super::{condition::Condition, recorder::Flight};
use crate::observe::probe::Probe;

impl Flight {
    /// Keeps the contents before the process crashes, with the crash as the event. `still` says
    /// that no cycle is in progress. Returns the messages to report.
    pub(crate) fn salvage(&mut self, still: bool, now: i64, why: &str) -> Vec<String> {
        if self.ends {
            // It has been switched off, and its files are complete.
            return Vec::new();
        }
        if let Some((id, probe, columns)) = self.probe.take() {
            if still {
                probe.sample(now);
            }
            self.read_changes(&probe, &columns, true);
            self.probe = Some((id, probe, columns));
        }
        self.event(now, &format!("crash: {why}"));
        self.at_once = true;
        // Memory is lost with the process.
        self.ends = true;
        self.finish(now);
        core::mem::take(&mut self.said)
    }

    /// Reads queued changes. `whole` says that no sample is in progress, so no more changes of the
    /// latest one will come.
    pub(super) fn read_changes(&mut self, probe: &Probe, columns: &[u32], whole: bool) {
        let looks = probe.samples();
        while let Some((time, which, bits)) = probe.change() {
            let Some(column) = columns.get(which as usize).copied() else { continue };
            if self.open.is_some_and(|(at, _)| at < time) {
                self.judge();
            }
            if self.awaited.as_ref().is_some_and(|a| a.until < time) {
                self.finish(time);
            }
            if !self.history.push(time, column, bits) {
                continue;
            }
            if let Some(about) = self.by_column.get(&column) {
                for i in about {
                    self.conditions.get_mut(*i).into_iter().for_each(|c| c.stirred = true);
                }
                self.open = Some((time, probe.samples()));
            }
        }
        if whole || self.open.is_some_and(|(_, then)| then < looks) {
            self.judge();
        }
        if let Some(before) = self.spec.before_ns.filter(|_| self.awaited.is_none()) {
            let now = self.history.latest();
            self.history.keep_from(now.saturating_sub(i64::try_from(before).unwrap_or(i64::MAX)));
        }
    }

    /// Evaluates the conditions for a complete sample.
    pub(super) fn judge(&mut self) {
        let Some((time, _)) = self.open.take() else { return };
        let stirred = self.conditions.iter_mut().filter(|c| c.stirred);
        let events = stirred.filter_map(|c| c.sees(&self.history).then(|| c.why.clone()));
        let events: Vec<String> = events.collect();
        events.iter().for_each(|why| self.event(time, why));
    }

    /// Updates the columns of all conditions, and adds the conditions that every machine has.
    pub(super) fn look_out(&mut self, now: i64) {
        for (name, ty) in self.history.present() {
            if self.conditions.iter().all(|c| !c.is_of(&name))
                && let Some(usual) = Condition::usual(&name, ty)
            {
                self.conditions.push(usual);
            }
        }
        self.by_column.clear();
        for (i, c) in self.conditions.iter_mut().enumerate() {
            if c.find(&self.history) {
                c.stirred = true;
                self.open = Some((now, 0));
            }
            for column in &c.columns {
                self.by_column.entry(*column).or_default().push(i);
            }
        }
    }
}

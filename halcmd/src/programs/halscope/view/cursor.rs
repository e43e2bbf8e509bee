//! Positions of the cursors, and their movements.

use super::state::State;
use hal_trace::{
    Trace,
    trigger::{Condition, When},
};

impl State {
    /// Activates a cursor. If it is not in view, puts it in the middle.
    pub(super) fn cursor(&mut self, which: usize) {
        let (from, to, middle) = (self.from, self.to, self.from.saturating_add(self.width() / 2));
        self.active = which;
        if let Some(cursor) = self.cursors.get_mut(which) {
            let at = cursor.filter(|at| from <= *at && *at < to);
            *cursor = Some(at.unwrap_or(middle));
        }
    }

    /// Moves the active cursor by this number of columns.
    pub(super) fn step(&mut self, columns: i64) {
        let column = self.width() / i64::try_from(self.columns.max(1)).unwrap_or(1);
        let by = column.max(1).saturating_mul(columns);
        let at = self.cursors.get(self.active).copied().flatten();
        match at {
            None => self.cursor(self.active),
            Some(at) => self.put(at.saturating_add(by)),
        }
    }

    /// Puts the active cursor at a time and brings it into view.
    pub(super) fn put(&mut self, at: i64) {
        let (first, last) = self.ends();
        let at = at.max(first).min(last);
        if let Some(cursor) = self.cursors.get_mut(self.active) {
            *cursor = Some(at);
        }
        if at < self.from || self.to <= at {
            let middle = self.from.saturating_add(self.width() / 2);
            self.pan(at.saturating_sub(middle));
        }
    }

    /// Moves the active cursor to the next or previous change of the selected channel.
    pub(super) fn edge(&mut self, is_next: bool) {
        let channel = self.lane().and_then(|l| self.trace.channels().get(l.chosen.channel));
        let Some(channel) = channel else { return };
        let outside = if is_next { self.from.saturating_sub(1) } else { self.to };
        let from = self.cursors.get(self.active).copied().flatten().unwrap_or(outside);
        let times = self.trace.times();
        let number = if is_next {
            // The initial value is not a change.
            Some(channel.changes_before(times.from(from.saturating_add(1))).max(1))
        } else {
            channel.changes_before(times.from(from)).checked_sub(1).filter(|n| *n > 0)
        };
        let change = number.and_then(|n| channel.change(n));
        match change.and_then(|c| times.get(c.sample)) {
            Some(at) => self.put(at),
            None => {
                let way = if is_next { "later" } else { "earlier" };
                self.said = format!("{} does not change {way}", channel.name());
            }
        }
    }

    /// Moves the active cursor to the next marker; after the last one, to the first.
    pub(super) fn marker(&mut self) {
        let from = self.cursors.get(self.active).copied().flatten().unwrap_or(i64::MIN);
        let markers = self.trace.markers();
        let next = markers.iter().find(|m| m.at > from).or_else(|| markers.first());
        match next.cloned() {
            Some(marker) => {
                self.put(marker.at);
                self.said = marker.text;
            }
            None => self.said = "there are no markers".to_owned(),
        }
    }

    /// Moves the active cursor to the next time at which a condition holds.
    pub(super) fn go(&mut self, text: &str) {
        let from = self.cursors.get(self.active).copied().flatten();
        let from = from.map_or(0, |at| self.trace.times().from(at.saturating_add(1)));
        let found = condition(&self.trace, text).map(|when| when.first(&self.trace, from));
        match found {
            Ok(sample) => match sample.and_then(|s| self.trace.times().get(s)) {
                Some(at) => self.put(at),
                None => self.said = format!("'{text}' does not hold later"),
            },
            Err(why) => self.said = why,
        }
    }
}

/// Binds a condition to a trace's channels, each under the name that the condition uses.
fn condition(trace: &Trace, text: &str) -> Result<When, String> {
    let said = |e: hal_trace::trigger::ConditionError| e.why().to_owned();
    let condition = Condition::parse(text).map_err(said)?;
    let called = condition.names();
    let channels = trace.channels().iter().map(|c| {
        let name = c.names().iter().find(|n| called.contains(&n.as_str()));
        (name.map_or(c.name(), String::as_str).to_owned(), c.ty())
    });
    condition.bind(&channels.collect::<Vec<_>>()).map_err(said)
}

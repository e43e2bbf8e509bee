//! Waveforms that moved as a whole. At the ends of the window, edges leave it or come into it.

use super::{WaveLine, rounded};

/// A shift of several edges by the same time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shift {
    /// Time in microseconds; positive is later.
    by: f64,
    /// Number of edges that are in both drawings.
    moved: usize,
    /// Number of edges that have left the window, and that have come into it.
    left: usize,
    come: usize,
}

impl Shift {
    /// Finds the shift that turns all old lines into the new ones with the same names. `ends` are the times that the
    /// old and the new drawing reach at least.
    pub(super) fn of(old: &[&WaveLine], new: &[&WaveLine], ends: (f64, f64)) -> Option<Self> {
        let pairs: Vec<(&WaveLine, &WaveLine)> = old
            .iter()
            .map(|line| Some((*line, *new.iter().find(|l| l.name == line.name)?)))
            .collect::<Option<_>>()?;
        if pairs.len() != new.len() {
            return None;
        }
        // An edge near the start of the window is also one of the first of the other drawing.
        let first = pairs.iter().find(|(old, _)| !old.changes.is_empty())?;
        let from = first.0.changes.iter().take(NEAR);
        let times =
            from.flat_map(|a| first.1.changes.iter().take(NEAR).map(|b| rounded(b.0 - a.0)));
        let mut times: Vec<f64> = times.filter(|by| *by != 0.0).collect();
        times.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let mut found = times.into_iter().filter_map(|by| {
            pairs.iter().try_fold(Self { by, ..Self::default() }, |sum, pair| sum.and(*pair, ends))
        });
        // One edge alone says nothing about the others.
        found.find(|shift| shift.moved > 1 && shift.moved > shift.left + shift.come)
    }

    /// Adds a line, if this shift explains all of its changes.
    fn and(
        self,
        (old, new): (&WaveLine, &WaveLine),
        (old_end, new_end): (f64, f64),
    ) -> Option<Self> {
        let (a, b) = (&old.changes, &new.changes);
        // Edges that left the window at its start, or came into it there.
        let (gone, early) = if self.by < 0.0 {
            (a.iter().take_while(|e| e.0 + self.by <= 0.0).count(), 0)
        } else {
            (0, b.iter().take_while(|e| e.0 - self.by <= 0.0).count())
        };
        if gone == 0 && early == 0 && old.first != new.first {
            return None;
        }
        let (a, b) = (a.get(gone..)?, b.get(early..)?);
        let both = a.len().min(b.len());
        let same = a.iter().zip(b).all(|(a, b)| a.1 == b.1 && rounded(b.0 - a.0) == self.by);
        // The other ends of the lines must be beyond what the other drawing shows.
        let beyond = a.get(both..)?.iter().all(|e| e.0 + self.by >= new_end)
            && b.get(both..)?.iter().all(|e| e.0 - self.by >= old_end);
        (same && beyond).then_some(Self {
            by: self.by,
            moved: self.moved + both,
            left: self.left + gone + (a.len() - both),
            come: self.come + early + (b.len() - both),
        })
    }

    /// Returns whether edges have left the window or come into it.
    pub(super) const fn crosses_ends(&self) -> bool {
        self.left + self.come > 0
    }

    /// Describes the shift of `what`.
    pub(super) fn told(&self, what: &str) -> String {
        let way = if self.by < 0.0 { "earlier" } else { "later" };
        let mut text = format!("{what} is {} µs {way}", self.by.abs());
        for (n, did) in [(self.left, "left the window"), (self.come, "come into it")] {
            match n {
                0 => {}
                1 => text.push_str(&format!("; 1 edge has {did}")),
                n => text.push_str(&format!("; {n} edges have {did}")),
            }
        }
        text
    }
}

/// Number of changes at the start of a line that are compared to find a shift.
const NEAR: usize = 8;

/// Returns the time of the last change of all lines.
pub(super) fn last(lines: &[&WaveLine]) -> f64 {
    let times = lines.iter().filter_map(|l| l.changes.last()).map(|c| c.0);
    times.fold(0.0, f64::max)
}

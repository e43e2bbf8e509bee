//! The time that a program takes, without accelerations and waits: an estimate from lengths, feeds and highest speeds.

use crate::{
    machine::Machine,
    way::{Kind, distance},
};
use hal_gcode::{
    Call, Issued, State,
    axis::{Axis, Position},
    state::FeedMode,
};

/// Largest number of marks in a time table.
const MAX_MARKS: usize = 4096;

/// The estimate of the moves so far.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Seconds.
    pub seconds: f64,
    feed: f64,
    per_revolution: bool,
    speed: f64,
}

impl Estimate {
    /// Begins in the state of a program.
    pub fn new(state: &State) -> Self {
        let modal = &state.modal;
        Self {
            seconds: 0.0,
            feed: modal.feed,
            per_revolution: modal.feed_mode == FeedMode::PerRevolution,
            speed: modal.spindles.first().map_or(0.0, |s| s.speed),
        }
    }

    /// Follows the calls that change the feed, and dwells.
    pub fn call(&mut self, issued: &Issued) {
        match issued.call {
            // In inverse time, each move has its own.
            Call::SetFeedRate(feed) => self.feed = feed,
            Call::SetFeedMode { per_revolution, .. } => self.per_revolution = per_revolution,
            Call::SetSpindleSpeed { spindle: 0, speed } => self.speed = speed,
            Call::Dwell(seconds) if seconds > 0.0 => self.seconds += seconds,
            _ => {}
        }
    }

    /// Adds a straight move. The unit is that of the program in millimetres.
    pub fn add(&mut self, machine: &Machine, kind: Kind, unit: f64, from: Position, to: Position) {
        let length = distance(from, to);
        let slowest = Axis::ALL.into_iter().zip(machine.rates).filter_map(|(axis, [top, ..])| {
            top.filter(|top| *top > 0.0).map(|top| (to[axis] - from[axis]).abs() / top)
        });
        let at_top = slowest.fold(length / machine.top_speed.0, f64::max);
        let turns = if self.per_revolution { self.speed } else { 1.0 };
        let rate = self.feed * turns * unit / 60.0;
        let at_feed = if kind == Kind::Feed && rate > 0.0 { length / rate } else { 0.0 };
        let seconds = at_top.max(at_feed);
        self.seconds += if seconds.is_finite() { seconds } else { 0.0 };
    }
}

/// The seconds that a program has taken before its lines.
#[derive(Clone, Debug)]
pub struct TimeTable {
    /// Number of a line in the order of execution, and the seconds before it.
    marks: Vec<(u64, f64)>,
    /// Number of lines between two marks.
    every: u64,
}

impl Default for TimeTable {
    fn default() -> Self {
        Self { marks: Vec::new(), every: 1 }
    }
}

impl TimeTable {
    /// Notes the seconds before a line; the lines come in their order.
    pub fn add(&mut self, number: u64, seconds: f64) {
        if self.marks.last().is_some_and(|(last, _)| number < last.saturating_add(self.every)) {
            return;
        }
        if self.marks.len() >= MAX_MARKS {
            let mut at = 0_usize;
            self.marks.retain(|_| {
                at += 1;
                at % 2 == 1
            });
            self.every = self.every.saturating_mul(2);
        }
        self.marks.push((number, seconds));
    }

    /// Returns the seconds before a line, between two marks in proportion.
    pub fn at(&self, number: u64) -> f64 {
        let next = self.marks.partition_point(|(n, _)| *n <= number);
        let before = next.checked_sub(1).and_then(|n| self.marks.get(n));
        match (before, self.marks.get(next)) {
            (Some((a, t)), Some((b, u))) => {
                t + (u - t) * (number - a) as f64 / b.saturating_sub(*a).max(1) as f64
            }
            (Some((_, t)), None) | (None, Some((_, t))) => *t,
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_table_of_many_lines_is_short_and_near() {
        let mut table = TimeTable::default();
        for number in 0..1_000_000 {
            table.add(number, number as f64 * 0.5);
        }
        assert!(table.marks.len() <= MAX_MARKS);
        for number in [0, 1, 777, 123_456, 999_000] {
            let seconds = table.at(number);
            assert!((seconds - number as f64 * 0.5).abs() < 1e-6, "{number}: {seconds}");
        }
        assert!(table.at(u64::MAX) <= 500_000.0);
    }
}

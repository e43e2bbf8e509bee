//! Realtime. Overrides ahead: a motion brakes for a move whose override is lower, before it gets there.

use super::Follower;
use crate::{
    scales::Scales,
    track::{Cell, Path},
};

/// Largest number of cells ahead that are examined.
const AHEAD: usize = 4;

impl Follower {
    /// Returns the highest speed of this period from which the input can brake for the overrides of the next cells;
    /// infinity where these are no lower than planned. The limits of speed, acceleration and jerk do not depend on it.
    pub(super) fn cap_ahead(&mut self, track: &impl Path, scales: &Scales) -> f64 {
        // With one factor for all moves, no move is slower than planned beside the others.
        if scales.feed == scales.rapid || !self.begun || self.is_alike_ahead(track) {
            return f64::INFINITY;
        }
        let Some(cell) = track.cell(self.cell) else { return f64::INFINITY };
        // The input may accelerate once more, and then has to wait before it brakes.
        let speed = self.speed + cell.rest * self.period;
        let margin = speed * (self.pause() + 2.0 * self.period);
        // Half the acceleration at rest is enough to stop in this cell.
        if cell.rest * (self.to_go - margin) > speed * speed {
            return f64::INFINITY;
        }
        let (mut ahead, mut count, mut number) = ([cell; AHEAD], 0, self.cell);
        for slot in &mut ahead {
            let Some((k, next)) = self.beyond(track, number) else { break };
            (*slot, number) = (next, k);
            count += 1;
        }
        let floor = |cell: &Cell| if self.back { cell.begin } else { cell.end };
        let (mut square, mut rest) = (f64::INFINITY, 0.0);
        for next in ahead.iter().take(count).rev() {
            if square < floor(next) {
                let length = less(&mut rest, next.length);
                square = Cell { length, ..*next }.reach(square);
            } else {
                square = next.reach(floor(next));
            }
            let cap = next.scaled(scales);
            if kinds(next) != kinds(&cell) && cap * cap <= square {
                (square, rest) = (cap * cap, margin);
            }
        }
        if square >= floor(&cell) {
            return f64::INFINITY;
        }
        let braking = cell.rest - cell.fade * cell.reach(square);
        (square + 2.0 * braking * less(&mut rest, self.to_go)).sqrt()
    }

    /// Returns true if the next cells belong to the same kinds of moves as the cell of the input. Each cell is read once.
    fn is_alike_ahead(&mut self, track: &impl Path) -> bool {
        let (cell, back) = (self.cell, self.back);
        let is_past = if back { self.alike > cell } else { self.alike < cell };
        if is_past {
            self.alike = cell;
        }
        let mut here = None;
        while cell.abs_diff(self.alike) < AHEAD as u64 {
            let Some((k, next)) = self.beyond(track, self.alike) else { return true };
            let here = *here.get_or_insert_with(|| track.cell(cell).map(|c| kinds(&c)));
            if here != Some(kinds(&next)) {
                return false;
            }
            self.alike = k;
        }
        true
    }

    /// Returns the cell behind this one in the direction of motion, and its number.
    fn beyond(&self, track: &impl Path, number: u64) -> Option<(u64, Cell)> {
        let next = if self.back { number.checked_sub(1) } else { Some(number + 1) };
        next.and_then(|k| Some((k, track.cell(k)?)))
    }
}

/// Returns the kinds of moves to which a cell belongs: feeds, rapid moves, or both.
fn kinds(cell: &Cell) -> [bool; 2] {
    [cell.feed, cell.rapid].map(f64::is_finite)
}

/// Returns a length without its part of a margin, which becomes shorter by that part.
const fn less(margin: &mut f64, length: f64) -> f64 {
    let part = if length < *margin { length } else { *margin };
    *margin -= part;
    length - part
}

//! Realtime. Overrides and highest speeds ahead: a motion brakes for a move whose override is lower, or whose group of axes is
//! faster at the same speed along the path, before it gets there.

use super::Follower;
use crate::{
    scales::Scales,
    tops::Tops,
    track::{Cell, Path},
};

/// Largest number of cells ahead whose overrides count.
const AHEAD: usize = 4;

/// Largest number of cells that a period reads in its search for an override of 0; no period passes more of them.
const SEARCHED: usize = 8;

/// The cells beyond that of the input that belong to the same kinds of moves, as far as is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Alike {
    /// Number of the farthest one in the direction of motion.
    last: u64,
    /// Length of all of them.
    pub(super) length: f64,
    /// Least acceleration at rest in them, and greatest loss of it per squared speed. Cells that the input has left still count:
    /// it may brake earlier before a move that is held, where it waits anyway.
    rest: f64,
    fade: f64,
    /// True if their lead groups have the same speeds too.
    leads: bool,
}

impl Alike {
    /// Nothing is known beyond this cell.
    pub(super) const fn none(cell: u64) -> Self {
        Self { last: cell, length: 0.0, rest: f64::INFINITY, fade: 0.0, leads: true }
    }

    /// Adds the next cell in the direction of motion; `here` is one of the others.
    fn add(&mut self, number: u64, cell: &Cell, here: &Cell) {
        self.last = number;
        self.length += cell.length;
        self.rest = self.rest.min(cell.rest);
        self.fade = self.fade.max(cell.fade);
        self.leads &= leads(cell) == leads(here);
    }
}

impl Follower {
    /// Returns the highest speed of this period from which the input can brake for the overrides and highest speeds of the next
    /// cells; infinity where these are no lower than planned. The limits of speed, acceleration and jerk do not depend on it.
    pub(super) fn cap_ahead(&mut self, track: &impl Path, scales: &Scales) -> f64 {
        // With one factor for all moves, no move is slower than planned beside the others.
        if scales.feed == scales.rapid && self.tops == Tops::NONE || !self.begun {
            return f64::INFINITY;
        }
        let is_past =
            if self.back { self.alike.last > self.cell } else { self.alike.last < self.cell };
        if is_past {
            self.alike = Alike::none(self.cell);
        }
        let cap = self.cap_of_next(track, scales);
        if scales.feed != scales.rapid && (scales.feed == 0.0 || scales.rapid == 0.0) {
            return cap.min(self.cap_before_hold(track, scales));
        }
        cap
    }

    /// Returns the highest speed of this period from which the input can stop before moves that are held, as far as they
    /// have been found within twice its braking distance. Each cell is read once, a few in each period.
    fn cap_before_hold(&mut self, track: &impl Path, scales: &Scales) -> f64 {
        let Some(cell) = track.cell(self.cell) else { return f64::INFINITY };
        let (highest, margin) = self.margin(&cell);
        for _ in 0..SEARCHED {
            let Some((k, next)) = self.beyond(track, self.alike.last) else { break };
            let Alike { length, rest, fade, .. } = self.alike;
            // One cell as slow as the slowest of them.
            let (rest, fade, speed) = (rest.min(cell.rest), fade.max(cell.fade), f64::INFINITY);
            let square =
                |way: f64| Cell { length: way.max(0.0), rest, fade, speed, ..cell }.reach(0.0);
            if kinds(&next) != kinds(&cell) {
                let is_held = next.scaled(scales) == 0.0;
                let way = self.to_go + length - margin;
                return if is_held { square(way).sqrt() } else { f64::INFINITY };
            }
            if square(0.5 * (length - margin)) > highest * highest {
                break;
            }
            self.alike.add(k, &next, &cell);
        }
        f64::INFINITY
    }

    /// Returns the speed from which the input brakes, and the way before that: it may accelerate once more, and then has to
    /// wait.
    fn margin(&self, cell: &Cell) -> (f64, f64) {
        let speed = self.speed + cell.rest * self.period;
        (speed, speed * (self.pause() + 2.0 * self.period))
    }

    /// Returns the highest speed of this period from which the input can brake for the overrides of the next cells.
    fn cap_of_next(&mut self, track: &impl Path, scales: &Scales) -> f64 {
        if self.is_alike_ahead(track) {
            return f64::INFINITY;
        }
        let Some(cell) = track.cell(self.cell) else { return f64::INFINITY };
        let (speed, margin) = self.margin(&cell);
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
            let cap = self.cap_beside(&cell, next, scales);
            if cap * cap <= square {
                (square, rest) = (cap * cap, margin);
            }
        }
        if square >= floor(&cell) {
            return f64::INFINITY;
        }
        let braking = cell.rest - cell.fade * cell.reach(square);
        (square + 2.0 * braking * less(&mut rest, self.to_go)).sqrt()
    }

    /// Returns the highest speed along another cell, as far as it may be lower than along the cell of the input for the
    /// overrides or the highest speeds.
    fn cap_beside(&self, cell: &Cell, next: &Cell, scales: &Scales) -> f64 {
        let mut cap = f64::INFINITY;
        if scales.feed != scales.rapid && kinds(next) != kinds(cell) {
            cap = next.scaled(scales);
        }
        if leads(next) != leads(cell) {
            cap = cap.min(next.topped(&self.tops));
        }
        cap
    }

    /// Returns true if the next cells belong to the same kinds of moves as the cell of the input. Each cell is read once.
    fn is_alike_ahead(&mut self, track: &impl Path) -> bool {
        if !self.alike.leads {
            return false;
        }
        let mut here = None;
        while self.cell.abs_diff(self.alike.last) < AHEAD as u64 {
            let Some((k, next)) = self.beyond(track, self.alike.last) else { return true };
            let Some(here) = *here.get_or_insert_with(|| track.cell(self.cell)) else {
                return false;
            };
            if (kinds(&here), leads(&here)) != (kinds(&next), leads(&next)) {
                return false;
            }
            self.alike.add(k, &next, &here);
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

/// Returns the speeds of the lead groups of a cell, at a speed of 1 along the path.
const fn leads(cell: &Cell) -> [f32; 2] {
    [cell.lead, cell.linear]
}

/// Returns a length without its part of a margin, which becomes shorter by that part.
const fn less(margin: &mut f64, length: f64) -> f64 {
    let part = if length < *margin { length } else { *margin };
    *margin -= part;
    length - part
}

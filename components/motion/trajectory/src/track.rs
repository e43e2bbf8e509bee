//! The track: the planned path as cells, each with its curve and its speed.
//!
//! A cell is a piece of one curve with constant limits. It carries everything that the follower needs; nothing is
//! found again from sums of lengths. Two values of b = v² belong to each cell: `end`, the highest at its end from which
//! the motion can still stop at the end of the track (backward sweep), and `begin`, the highest at its start that a
//! motion from rest at the start of the run can reach (forward sweep; it bounds reverse motion). `end` only rises while
//! cells are added, so a motion below the old values is below the new ones.

use std::collections::VecDeque;

use crate::{curve::Curve, scales::Scales, tops::Tops};

/// Path of a follower: the [`Track`] itself, or the [`Reader`](crate::Reader) of a planner in another thread.
pub trait Path {
    /// Returns a cell by its number.
    fn cell(&self, number: u64) -> Option<Cell>;

    /// Returns true if there is a cell with this number.
    fn has(&self, number: u64) -> bool;

    /// Returns a curve by its number. It never changes.
    fn curve(&self, number: u64) -> Option<Curve>;

    /// Returns true if the motion, which rests, may begin in this direction.
    fn may_turn(&self, _reverse: bool) -> bool {
        true
    }

    /// Reports the oldest cell that the follower still uses.
    fn release(&self, _oldest: u64) {}
}

/// A piece of the path with constant limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Number of its curve in the track.
    pub curve: u64,
    /// Path coordinate of the curve at the start of the cell.
    pub from: f64,
    /// Length in the path coordinate.
    pub length: f64,
    /// Highest speed along the path, in units of the path coordinate per second.
    pub speed: f64,
    /// Programmed speed along the path at a feed override of 1; infinity in a rapid move.
    pub feed: f64,
    /// Speed along the path at a rapid override of 1; infinity in a move at a feed. A blend between both kinds has both.
    pub rapid: f64,
    /// Highest speed of the group that governs the feed, at a speed of 1 along the path.
    pub lead: f32,
    /// The same where that group is of lengths; 0 where it is of angles.
    pub linear: f32,
    /// Highest acceleration along the path at rest.
    pub rest: f64,
    /// Loss of acceleration per squared speed.
    pub fade: f64,
    /// Highest squared speed at the end.
    pub end: f64,
    /// Highest squared speed at the start, for reverse motion.
    pub begin: f64,
    /// Servo periods that the jerk filter averages.
    pub samples: u16,
    /// True if the motion rests at the end until the filter is flat.
    pub stop: bool,
    /// Line of the program.
    pub line: u32,
}

impl Cell {
    /// Returns the programmed speed at overrides of 1.
    pub(crate) const fn programmed(&self) -> f64 {
        self.feed.min(self.rapid)
    }

    /// Returns the programmed speed at these overrides: the lower one where both kinds of moves meet.
    pub(crate) const fn scaled(&self, scales: &Scales) -> f64 {
        const fn times(speed: f64, scale: f64) -> f64 {
            // Infinity times zero is NaN.
            if speed < f64::INFINITY { speed * scale } else { speed }
        }
        times(self.feed, scales.feed).min(times(self.rapid, scales.rapid))
    }

    /// Returns the speed along the path at which the group that governs the feed has its highest speed.
    pub(crate) const fn topped(&self, tops: &Tops) -> f64 {
        let feed = tops.feed / self.lead as f64;
        // No speed of a length is too high for angles.
        if self.linear > 0.0 { feed.min(tops.linear / self.linear as f64) } else { feed }
    }

    /// Returns the highest squared speed at the far end of the cell for a motion that has `near` at the other end.
    pub(crate) fn reach(&self, near: f64) -> f64 {
        let l = 2.0 * self.length;
        ((near + l * self.rest) / (1.0 + l * self.fade)).min(self.speed * self.speed)
    }

    /// Returns the deceleration along the cell on the way to `end`.
    pub(crate) fn braking(&self) -> f64 {
        self.rest - self.fade * self.reach(self.end)
    }

    /// Returns the length from the start over which full speed is below the curve of highest speeds; 0 if the curve is lower
    /// at the start already.
    pub(crate) fn unbraked(&self) -> f64 {
        let full = self.speed * self.speed;
        if self.reach(self.end) < full {
            return 0.0;
        }
        let way = (full - self.end) / (2.0 * self.braking());
        if way > 0.0 { (self.length - way).max(0.0) } else { self.length }
    }

    /// Returns the deceleration of reverse motion along the cell on the way to `begin`.
    pub(crate) fn braking_back(&self) -> f64 {
        self.rest - self.fade * self.reach(self.begin)
    }
}

/// The planned path that has not been forgotten yet.
#[derive(Clone, Debug, Default)]
pub struct Track {
    cells: VecDeque<Cell>,
    curves: VecDeque<Curve>,
    first_cell: u64,
    first_curve: u64,
    /// Number of cells, from the start, whose `end` is final up to the end of the track.
    swept: u64,
}

impl Path for Track {
    fn cell(&self, number: u64) -> Option<Cell> {
        Self::cell(self, number).copied()
    }

    fn has(&self, number: u64) -> bool {
        Self::cell(self, number).is_some()
    }

    fn curve(&self, number: u64) -> Option<Curve> {
        Self::curve(self, number).copied()
    }
}

impl Track {
    /// Returns a cell by its number.
    pub fn cell(&self, number: u64) -> Option<&Cell> {
        let k = number.checked_sub(self.first_cell)?;
        self.cells.get(usize::try_from(k).ok()?)
    }

    /// Returns a curve by its number.
    pub fn curve(&self, number: u64) -> Option<&Curve> {
        let k = number.checked_sub(self.first_curve)?;
        self.curves.get(usize::try_from(k).ok()?)
    }

    /// Number of the oldest cell that is kept.
    pub const fn oldest(&self) -> u64 {
        self.first_cell
    }

    /// Number of cells kept.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Returns true if no cell is kept.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Returns the cells kept, oldest first.
    pub fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter()
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>() + self.curves.capacity() * size_of::<Curve>()
    }

    /// Forgets cells before `number`, and their curves. Reverse motion can then return to the start of that cell. Returns
    /// the number of the first cell whose `begin` has not changed.
    pub fn forget(&mut self, number: u64) -> u64 {
        if number <= self.first_cell {
            return self.first_cell;
        }
        while self.first_cell < number && self.cells.len() > 1 {
            self.cells.pop_front();
            self.first_cell += 1;
        }
        if let Some(curve) = self.cells.front().map(|c| c.curve) {
            while self.first_curve < curve && self.curves.len() > 1 {
                self.curves.pop_front();
                self.first_curve += 1;
            }
        }
        // Reverse motion must come to rest at the new start.
        let mut begin = 0.0;
        let mut same = self.first_cell;
        for cell in &mut self.cells {
            if cell.begin <= begin {
                break;
            }
            cell.begin = begin;
            begin = if cell.stop { 0.0 } else { cell.reach(begin) };
            same += 1;
        }
        same
    }

    pub(crate) fn add_curve(&mut self, curve: &Curve) -> u64 {
        self.curves.push_back(*curve);
        self.first_curve + self.curves.len() as u64 - 1
    }

    /// Adds a cell at the end. Its speeds are found by [`Track::sweep`].
    pub(crate) fn add_cell(&mut self, mut cell: Cell) {
        cell.end = 0.0;
        cell.begin = self.cells.back().map_or(0.0, |last| {
            if last.stop { 0.0 } else { last.reach(last.begin).min(cell.speed * cell.speed) }
        });
        self.cells.push_back(cell);
    }

    /// Marks the last cell as a stop.
    pub(crate) fn stop_at_end(&mut self) {
        if let Some(last) = self.cells.back_mut() {
            last.stop = true;
        }
    }

    /// Backward sweep: raises `end` of every cell as far as the cells after it allow. Returns the number of the first cell
    /// that has changed.
    pub(crate) fn sweep(&mut self) -> u64 {
        let mut next = 0.0;
        let mut changed = self.first_cell + self.cells.len() as u64;
        let total = self.first_cell + self.cells.len() as u64;
        let old = self.cells.len()
            - usize::try_from(total - self.swept.max(self.first_cell)).unwrap_or(0);
        for (k, cell) in self.cells.iter_mut().enumerate().rev() {
            let end = if cell.stop { 0.0 } else { f64::min(next, cell.speed * cell.speed) };
            // Cells before the first unchanged one keep their values.
            if k < old && end == cell.end {
                break;
            }
            cell.end = end;
            next = cell.reach(end);
            changed = self.first_cell + k as u64;
        }
        self.swept = total;
        changed
    }
}

//! Realtime. The follower's output: its place on the track, and the pose there.

use super::Follower;
use crate::track::{Cell, Path};

impl Follower {
    /// Moves the output along the track.
    pub(super) fn advance(&mut self, track: &impl Path, travel: f64) {
        if self.is_flat() || self.samples == 1 {
            // Input and output agree but for rounding.
            if let Some(cell) = track.cell(self.cell) {
                self.output = self.place(&cell);
                self.carry = 0.0;
                return self.show(track, &cell);
            }
        } else {
            // Compensated summation: a crawl of hours must end where the input does.
            let more = travel - self.carry;
            let x = self.output.x + more;
            self.carry = (x - self.output.x) - more;
            self.output.x = x;
            while let Some(cell) = track.cell(self.output.cell) {
                if self.output.x > cell.length {
                    if !track.has(self.output.cell + 1) {
                        self.output.x = cell.length;
                        break;
                    }
                    self.output.x -= cell.length;
                    self.output.cell += 1;
                } else if self.output.x < 0.0 {
                    let before = self.output.cell.checked_sub(1);
                    let Some((k, before)) = before.and_then(|k| Some((k, track.cell(k)?))) else {
                        self.output.x = 0.0;
                        break;
                    };
                    self.output.x += before.length;
                    self.output.cell = k;
                } else {
                    break;
                }
            }
        }
        if let Some(cell) = track.cell(self.output.cell) {
            self.show(track, &cell);
        }
    }

    /// Finds the pose of the output, which is in this cell.
    fn show(&mut self, track: &impl Path, cell: &Cell) {
        if self.curve.as_ref().is_none_or(|(number, _)| *number != cell.curve) {
            let Some(curve) = track.curve(cell.curve) else { return };
            self.curve = Some((cell.curve, curve));
        }
        let Some((_, curve)) = &self.curve else { return };
        self.position = curve.pose(cell.from + self.output.x);
        self.line = cell.line;
        self.feed = cell.programmed();
        self.highest = cell.speed;
        self.lead = f64::from(cell.lead);
    }
}

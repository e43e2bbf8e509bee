//! The deviation of joined lines, bounded again.
//!
//! A point of a piece of a curve is a weighted mean of the piece's Bernstein points. With each Bernstein point goes the
//! nearest place on a line; the mean of these places, with the same weights, is on the line too. So the distance of the
//! piece from the line, in all groups at the same place, is at most the largest of the distances of the Bernstein points.
//! The plan compares equal path coordinates instead, and takes off the part along the line.

use crate::{
    curve::Curve,
    segment::{Segment, Tolerances},
};

/// Times that a piece is halved at most: for the proof that it is inside, and for the share of the tolerance that it uses.
const HALVINGS: [u32; 2] = [12, 2];

/// Times that a piece is halved at most for the largest distance. The bounds of the tests exceed it by less than a tenth.
const FARTHEST: u32 = 4;

/// Share of the tolerance that need not be known better.
const SMALL: f64 = 0.1;

/// Lines on either side of the expected one that are tried.
const AROUND: usize = 2;

/// A spline beside the lines that it joins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joined<'a> {
    /// Pieces of equal length, in order.
    pub(crate) curves: &'a [Curve],
    pub(crate) spacing: f64,
    pub(crate) lines: &'a [Segment],
    pub(crate) tolerances: &'a Tolerances,
}

impl Joined<'_> {
    /// Returns true if the distance of every point from the lines is inside the tolerance.
    pub(crate) fn is_inside(&self) -> bool {
        self.largest(0.0, f64::INFINITY, 1.0, HALVINGS[0]) <= 1.0
    }

    /// Bounds the shares of the tolerance that the ends use, as far as a blend reaches: half of the first and last piece.
    /// Every point is known to be inside, so a bound above 1 is only a coarse one.
    pub(crate) fn ends(&self) -> [f64; 2] {
        let half = 0.5 * self.spacing;
        let pieces = f64::from(u32::try_from(self.curves.len()).unwrap_or(u32::MAX));
        let last = self.spacing * pieces - half;
        [(0.0, half), (last, f64::INFINITY)]
            .map(|(a, b)| self.largest(a, b, SMALL, HALVINGS[1]).min(1.0))
    }

    /// Bounds the largest ratio of distance to tolerance, and returns the line of the program beside which it is.
    pub(crate) fn farthest(&self) -> (f64, u32) {
        let mut worst = (0.0_f64, 0);
        let mut from = 0.0;
        for line in self.lines {
            let to = from + line.length;
            if to > self.spacing * f64::from(u32::try_from(self.curves.len()).unwrap_or(u32::MAX)) {
                break;
            }
            // Lines that are nearer than the farthest so far need no better bound.
            let ratio = self.largest(from, to, worst.0.max(0.5 * SMALL), FARTHEST);
            if ratio > worst.0 {
                worst = (ratio, line.line);
            }
            from = to;
        }
        worst
    }

    /// Bounds the ratio of distance to tolerance between two path coordinates. A piece is halved while its bound is above
    /// `aim`.
    fn largest(&self, from: f64, to: f64, aim: f64, halvings: u32) -> f64 {
        let mut worst: f64 = 0.0;
        let (mut line, mut border) = (0, self.lines.first().map_or(0.0, |l| l.length));
        let mut start = 0.0;
        for curve in self.curves {
            let end = start + self.spacing;
            let mut a = from.max(start);
            while a < end.min(to) {
                // A piece ends where the line beside it ends, if they are of the same length.
                while border <= a && line + 1 < self.lines.len() {
                    line += 1;
                    border += self.lines.get(line).map_or(0.0, |l| l.length);
                }
                let last = line + 1 == self.lines.len();
                let b = end.min(to).min(if last { f64::INFINITY } else { border });
                worst = worst.max(self.part(curve, a - start, b - start, line, aim, halvings));
                if worst > 1.0 {
                    return worst;
                }
                a = b;
            }
            start = end;
        }
        worst
    }

    /// Bounds the ratio on a part of one curve, near a line.
    fn part(&self, curve: &Curve, a: f64, b: f64, line: usize, aim: f64, halvings: u32) -> f64 {
        let (p, q) = (curve.twice(a), curve.twice(b));
        let third = (b - a) / 3.0;
        let hull = [p.pose, p.pose + p.first * third, q.pose - q.first * third, q.pose];
        let beside = |line: usize| {
            let Some(segment) = self.lines.get(line) else { return f64::INFINITY };
            let (start, end) = (segment.curve.pose(0.0), segment.curve.pose(segment.length));
            let by = end - start;
            let square = by.dot(&by, segment.main);
            self.tolerances.ratios(hull.map(|point| {
                let from = point - start;
                let share = from.dot(&by, segment.main) / square;
                let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
                from - by * share
            }))
        };
        let mut best = beside(line);
        for k in 1..=AROUND {
            if best > aim {
                best = best.min(beside(line + k));
                best = best.min(line.checked_sub(k).map_or(f64::INFINITY, beside));
            }
        }
        if best <= aim || halvings == 0 {
            return best;
        }
        let middle = 0.5 * (a + b);
        let one = self.part(curve, a, middle, line, aim, halvings - 1);
        if one > 1.0 {
            return one;
        }
        best.min(one.max(self.part(curve, middle, b, line, aim, halvings - 1)))
    }
}

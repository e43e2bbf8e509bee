//! Joining of dense code: runs of short lines become a spline inside the tolerance.
//!
//! Up to [`MAX_LINES`] lines are sampled at equal distances; the samples are the control points of a uniform cubic
//! B-spline. Where a run goes on, the spline passes a vertex with the direction and curvature of the lines around it, and
//! the next window continues it with the same two derivatives; at the ends of the run it is straight. The largest distance between samples whose deviation
//! bound is inside the tolerance is taken; if there is none, the lines stay as they are.
//!
//! The bound: between two neighbouring vertices or knots, D, the difference between the spline and the line at the same
//! path coordinate, is a cubic and lies in the hull of its Bernstein points. The part of D along the line is taken off by
//! moving along the line; where that passes the end of the line by e, the distance to the next line is at most e times
//! the difference of their directions.

use crate::{
    certificate::{Certificate, Joined},
    curve::Curve,
    moves::Mode,
    pose::{Group, Pose},
    segment::{Segment, Tolerances, larger},
};

mod spline;

use spline::Spline;

/// Largest number of lines that are joined at once.
const MAX_LINES: usize = 64;

/// Number of lines that are kept for the next window where a run goes on.
const KEPT: usize = 16;

/// Number of lines on either side of a vertex that give its direction and curvature.
const AROUND: usize = 8;

/// Longest line that is joined.
const MAX_LENGTH: f64 = 1.0;

/// Smallest cosine of the angle between neighbouring lines of a run: 30°.
const STRAIGHT: f64 = 0.866;

/// Lines that wait to be joined.
#[derive(Clone, Debug, Default)]
pub(crate) struct Join {
    lines: Vec<Segment>,
    /// Two derivatives at the start, if the window before ends with them.
    end: Option<[Pose; 2]>,
    /// Distance between samples in the window before.
    spacing: f64,
}

impl Join {
    /// Returns true if a segment can be part of a run.
    pub(crate) fn is_dense(segment: &Segment) -> bool {
        segment.length <= MAX_LENGTH
            && segment.mode != Mode::ExactStop
            && matches!(segment.curve, Curve::Line { .. })
    }

    /// Returns true if a segment continues the run.
    pub(crate) fn continues(&self, next: &Segment) -> bool {
        let Some(last) = self.lines.last() else { return false };
        let cos = slope(last).dot(&slope(next), next.main);
        Self::is_dense(next)
            && last.mode == next.mode
            && (last.feed, last.rapid) == (next.feed, next.rapid)
            && (last.lead, last.main) == (next.lead, next.main)
            && cos >= STRAIGHT
    }

    /// Returns the first line that waits.
    pub(crate) fn first(&self) -> Option<Segment> {
        self.lines.first().copied()
    }

    /// Returns the lines that wait.
    pub(crate) fn lines(&self) -> &[Segment] {
        &self.lines
    }

    pub(crate) fn is_full(&self) -> bool {
        self.lines.len() >= MAX_LINES
    }

    pub(crate) fn push(&mut self, line: &Segment) {
        self.lines.push(*line);
    }

    /// Changes the end of the run to an exact stop.
    pub(crate) fn stop(&mut self) -> bool {
        if let Some(last) = self.lines.last_mut() {
            last.mode = Mode::ExactStop;
            return true;
        }
        false
    }

    /// Returns the number of lines that a window gives out: if the run goes on, without its last ones.
    fn count(&self, goes_on: bool) -> usize {
        let kept = if goes_on { KEPT.min(self.lines.len() / 2) } else { 0 };
        self.lines.len() - kept
    }

    /// Returns the smoothest spline through the window that the tolerances and the certificate allow. `most` are the
    /// tolerances of which its ends use a share.
    pub(crate) fn curve(
        &self,
        goes_on: bool,
        tolerances: &Tolerances,
        most: &Tolerances,
        certificate: &mut Certificate,
    ) -> Option<Joining> {
        let count = self.count(goes_on);
        let end = if goes_on { self.derivatives(count) } else { None };
        let window = Window { lines: self.lines.get(..count)?, spacing: self.spacing };
        let (first, last) = (window.lines.first()?, window.lines.last()?);
        let straight = [slope(first), slope(last)].map(|u| [u, Pose::ZERO]);
        let [from, to] = [window.one_sided(false), window.one_sided(true)];
        let from = self.end.or(from).unwrap_or(straight[0]);
        let to = end.or(to).unwrap_or(straight[1]);
        let spline = window.spline(&from, &to, tolerances).or_else(|| {
            let ends = [self.end.unwrap_or(straight[0]), end.unwrap_or(straight[1])];
            if ends == [from, to] { None } else { window.spline(&ends[0], &ends[1], tolerances) }
        })?;
        let (curves, spacing) = (spline.curves(), spline.spacing);
        let joined = Joined { curves: &curves, spacing, lines: window.lines, tolerances };
        if !certificate.allows_joining(&joined) {
            return None;
        }
        let ends = Joined { tolerances: most, ..joined }.ends();
        Some(Joining { curves, spacing, within: *tolerances, ends, end })
    }

    /// Gives out the window, as the spline or as the lines that it was; if the run goes on, without its last lines.
    pub(crate) fn give(&mut self, goes_on: bool, found: Option<Joining>) -> Vec<Segment> {
        let mut out = Vec::new();
        let count = self.count(goes_on);
        let rest = self.lines.split_off(count);
        let smooth = self.end.is_some();
        let (Some(first), Some(last)) = (self.lines.first(), self.lines.last()) else { return out };
        let last = *last;
        match found {
            Some(Joining { curves, spacing, ends, end, .. }) => {
                for (k, curve) in curves.iter().enumerate() {
                    let middle = spacing * (float(k) + 0.5);
                    let (mut line, mut s) = (last.line, 0.0);
                    for l in &self.lines {
                        s += l.length;
                        if s >= middle {
                            line = l.line;
                            break;
                        }
                    }
                    let mode = if k + 1 == curves.len() { last.mode } else { first.mode };
                    let (curve, length, smooth) = (*curve, spacing, k > 0 || smooth);
                    // What the ends use of the tolerance is not left for their blends.
                    let at_start = if k == 0 { ends[0] } else { 0.0 };
                    let off = if k + 1 == curves.len() { at_start.max(ends[1]) } else { at_start };
                    let of = Segment { lead_speed: first.lead_speed_on(&curve, length), ..*first };
                    out.push(Segment { curve, length, line, mode, smooth, off, ..of });
                }
                self.spacing = spacing;
                self.end = end;
            }
            None => {
                out.extend_from_slice(&self.lines);
                self.end = None;
            }
        }
        self.lines = rest;
        out
    }

    /// Returns the first two derivatives that the lines around the start of a line suggest.
    fn derivatives(&self, number: usize) -> Option<[Pose; 2]> {
        let before = self.lines.get(number.checked_sub(AROUND)?..number)?;
        let after = self.lines.get(number..number + AROUND)?;
        let ((a, x), (b, y)) = (chord(before)?, chord(after)?);
        let main = self.lines.first()?.main;
        let mean = (a * y + b * x) * (1.0 / (x + y));
        let tangent = unit(&mean, main)?;
        let bend = (b - a) * (2.0 / (x + y));
        Some([tangent, bend - tangent * bend.dot(&tangent, main)])
    }
}

/// A curve through the lines of a window.
#[derive(Clone, Debug)]
pub(crate) struct Joining {
    curves: Vec<Curve>,
    /// Length of each of them.
    spacing: f64,
    /// Tolerances within which it was found.
    within: Tolerances,
    /// Shares of the tolerance that both ends use.
    ends: [f64; 2],
    /// Two derivatives at the end, if the run goes on.
    end: Option<[Pose; 2]>,
}

impl Joining {
    /// Returns the curves, each as long as [`Self::spacing`].
    pub(crate) fn curves(&self) -> &[Curve] {
        &self.curves
    }

    /// Bounds the largest distance from these lines, which it joins, and returns the line of the program beside which it is.
    pub(crate) fn deviation(&self, lines: &[Segment]) -> (f64, u32) {
        let Self { curves, spacing, within, .. } = self;
        let joined = Joined { curves, spacing: *spacing, lines, tolerances: within };
        let (ratio, line) = joined.farthest();
        (ratio * within.linear, line)
    }

    /// Returns the length of each curve.
    pub(crate) const fn spacing(&self) -> f64 {
        self.spacing
    }
}

/// Lines that become a spline together.
#[derive(Clone, Copy, Debug)]
struct Window<'a> {
    lines: &'a [Segment],
    /// Distance between samples in the window before.
    spacing: f64,
}

impl Window<'_> {
    /// Returns the first two derivatives at the start or at the end of the lines, as the lines nearby suggest.
    fn one_sided(&self, at_end: bool) -> Option<[Pose; 2]> {
        let count = self.lines.len();
        let from = if at_end { count.checked_sub(2 * AROUND)? } else { 0 };
        let (a, x) = chord(self.lines.get(from..from + AROUND)?)?;
        let (b, y) = chord(self.lines.get(from + AROUND..from + 2 * AROUND)?)?;
        let main = self.lines.first()?.main;
        let bend = (b - a) * (2.0 / (x + y));
        // A chord has the direction of the curve at its middle.
        let tangent = if at_end { b + bend * (0.5 * y) } else { a - bend * (0.5 * x) };
        let tangent = unit(&tangent, main)?;
        Some([tangent, bend - tangent * bend.dot(&tangent, main)])
    }

    /// Finds the smoothest spline inside the tolerance.
    fn spline(&self, from: &[Pose; 2], to: &[Pose; 2], tolerances: &Tolerances) -> Option<Spline> {
        let count = self.lines.len();
        if count < 4 {
            return None;
        }
        let length: f64 = self.lines.iter().map(|l| l.length).sum();
        let guess = 1.7 * self.spacing;
        let mut pieces = if guess > 0.0 { (length / guess).ceil().max(4.0) } else { 4.0 };
        while pieces <= 2.0 * float(count) {
            let spline = self.sampled(length, pieces, from, to);
            for spline in [spline.through(), spline] {
                if self.deviation(&spline, tolerances) <= 1.0 - 1e-9 {
                    return Some(spline);
                }
            }
            pieces = (1.25 * pieces).ceil();
        }
        None
    }

    /// Samples the lines at equal distances.
    fn sampled(&self, length: f64, pieces: f64, from: &[Pose; 2], to: &[Pose; 2]) -> Spline {
        let h = length / pieces;
        let mut points = Vec::new();
        let (mut s, mut k) = (0.0, 2.0);
        for line in self.lines {
            while k <= pieces - 2.0 && k * h <= s + line.length {
                points.push(line.curve.pose(k * h - s));
                k += 1.0;
            }
            s += line.length;
        }
        let start = self.lines.first().map_or(Pose::ZERO, |l| l.curve.pose(0.0));
        let end = self.lines.last().map_or(Pose::ZERO, |l| l.curve.pose(l.length));
        // Rounding of sums must not lose a sample.
        while k <= pieces - 2.0 {
            points.push(end);
            k += 1.0;
        }
        // Three control points give a point and its first two derivatives.
        let three = |p: Pose, [first, second]: &[Pose; 2]| {
            let (a, b) = (*first * h, *second * (h * h / 3.0));
            [p - a + b, p - b * 0.5, p + a + b]
        };
        let mut control = three(start, from).to_vec();
        control.extend(points);
        control.extend(three(end, to));
        Spline { control, spacing: h }
    }

    /// Bounds the largest ratio of the spline's distance from the lines to the tolerance.
    fn deviation(&self, spline: &Spline, tolerances: &Tolerances) -> f64 {
        let h = spline.spacing;
        let mut worst: f64 = 0.0;
        let (mut begin, mut knot) = (0.0, 0);
        let last = spline.pieces().saturating_sub(1);
        let Some(mut piece) = spline.piece(0) else { return f64::INFINITY };
        let mut left = piece.at(0.0, h);
        for (k, line) in self.lines.iter().enumerate() {
            let near = |k: Option<usize>| k.and_then(|k| self.lines.get(k));
            let neighbours = [near(k.checked_sub(1)), near(Some(k + 1))];
            let end = begin + line.length;
            let mut a = begin;
            loop {
                let border = float(knot + 1) * h;
                let is_end = knot == last || border >= end;
                let b = if is_end { end } else { border };
                let right = piece.at(b - float(knot) * h, h);
                let between = [(a - begin, left), (b - begin, right)];
                worst = worst.max(part(&between, line, neighbours, tolerances));
                (a, left) = (b, right);
                if !is_end || border <= end && knot < last {
                    knot += 1;
                    let Some(next) = spline.piece(knot) else { return f64::INFINITY };
                    piece = next;
                    left = piece.at(a - float(knot) * h, h);
                }
                if is_end {
                    break;
                }
            }
            if worst > 1.0 {
                break;
            }
            begin = end;
        }
        worst
    }
}

/// Bounds the deviation of one piece of a spline between two path coordinates beside one line. With each coordinate, from
/// the start of the line, goes the spline's value and first derivative.
fn part(
    [(a, p), (b, q)]: &[(f64, [Pose; 2]); 2],
    line: &Segment,
    neighbours: [Option<&Segment>; 2],
    tolerances: &Tolerances,
) -> f64 {
    let u = slope(line);
    let third = (b - a) / 3.0;
    let (d0, d3) = (p[0] - line.curve.pose(*a), q[0] - line.curve.pose(*b));
    let points = [d0, d0 + (p[1] - u) * third, d3 - (q[1] - u) * third, d3];
    let (mut before, mut after) = (0.0_f64, 0.0_f64);
    let mut off = [0.0_f64; 3];
    for (k, d) in points.iter().enumerate() {
        let along = d.dot(&u, line.main);
        let x = a + third * float(k) + along;
        before = larger(before, -x);
        after = larger(after, x - line.length);
        let across = *d - u * along;
        for (o, group) in off.iter_mut().zip(Group::ALL) {
            *o = larger(*o, across.dot(&across, group));
        }
    }
    let mut worst: f64 = 0.0;
    for (o, group) in off.iter().zip(Group::ALL) {
        let mut more: f64 = 0.0;
        for (past, neighbour) in [before, after].into_iter().zip(neighbours) {
            if past <= 0.0 {
                continue;
            }
            let by = match neighbour {
                Some(n) if past <= n.length => (slope(n) - u).norm(group),
                _ => u.norm(group),
            };
            more = larger(more, past * by);
        }
        worst = larger(worst, (o.sqrt() + more) / tolerances.of(group));
    }
    worst
}

/// Returns the direction from the start to the end of lines, by their length, and the length.
fn chord(lines: &[Segment]) -> Option<(Pose, f64)> {
    let (first, last) = (lines.first()?, lines.last()?);
    let length: f64 = lines.iter().map(|l| l.length).sum();
    let by = last.curve.pose(last.length) - first.curve.pose(0.0);
    Some((by * (1.0 / length), length))
}

/// Returns the direction; `None` if there is none, as where lines lead as far back as forward.
fn unit(by: &Pose, main: Group) -> Option<Pose> {
    let per = 1.0 / by.norm(main);
    per.is_finite().then(|| *by * per)
}

/// Returns the derivative of a line.
fn slope(line: &Segment) -> Pose {
    match line.curve {
        Curve::Line { slope, .. } => slope,
        _ => line.curve.at(0.0).first,
    }
}

#[expect(clippy::cast_precision_loss, reason = "small numbers")]
const fn float(k: usize) -> f64 {
    k as f64
}

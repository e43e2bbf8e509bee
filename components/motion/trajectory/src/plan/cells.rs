//! Cells: pieces of the curves of the path, each with its own limits.

use super::{Planner, count};
use crate::{
    bounds::Bounds,
    curve::Curve,
    erosion::Raw,
    kinematics::{CELL, Kinematics, joint_bounds},
    pose::Group,
    segment::Segment,
    speed::{Allowed, Shares},
    track::Cell,
};

/// Largest number of cells that wait for the cells in reach of the jerk filter; the run ends with a stop before there are
/// more. Only cells that are much shorter than a hundredth of a millimetre are so many.
const MAX_WAITING: usize = 4096;

/// Largest number of cells of a span; cells of an arc with more turns are longer.
const MAX_PIECES: u16 = 4096;

/// A piece of a curve of the path, between two coordinates of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub(super) curve: Curve,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) pieces: u16,
}

impl<K: Kinematics> Planner<K> {
    /// Cuts a span into cells with limits.
    pub(super) fn add_span(&mut self, span: &Span, a: &Segment, b: Option<&Segment>) {
        let length = span.to - span.from;
        let shares = if b.is_some() { Shares::BLEND } else { Shares::MOVE };
        let mut pieces = span.pieces.min(MAX_PIECES);
        if !self.direct {
            pieces = pieces.max(count(length / CELL));
        } else if self.law.has_jerk() && matches!(span.curve, Curve::Poly { .. }) {
            // A polynomial that is short against the reach of the filter has one speed anyway.
            let whole = span.curve.bounds(span.from, span.to, a.lead);
            let speed =
                self.law.allowed(&whole, None, a.feed * self.machine.max_override, shares).speed;
            if length < speed * self.law.reach() {
                pieces = 1;
            }
        }
        let number = self.track.add_curve(&span.curve);
        let mut from = span.from;
        for k in 1..=pieces {
            let to = if k == pieces {
                span.to
            } else {
                span.from + length * (f64::from(k) / f64::from(pieces))
            };
            self.add_raw(number, &span.curve, from, to, a, b);
            from = to;
        }
    }

    /// Adds a cell with its own limits.
    fn add_raw(
        &mut self,
        number: u64,
        curve: &Curve,
        from: f64,
        to: f64,
        a: &Segment,
        b: Option<&Segment>,
    ) {
        let bounds = curve.bounds(from, to, a.lead);
        let shares = if b.is_some() { Shares::BLEND } else { Shares::MOVE };
        let [own, mut rapid] = programmed_along(curve, [from, to], &bounds, a, b);
        let feed = own.min(rapid);
        if self.erosion.known() == 0.0 {
            self.law.choose_filter(feed * self.machine.max_override);
        }
        let joints = if self.direct {
            None
        } else {
            // The door has checked the segment, and `place` the blend; lines that were joined are within the tolerance.
            joint_bounds(&self.kinematics, curve, from, to).ok()
        };
        let mut allowed =
            self.law.allowed(&bounds, joints.as_ref(), feed * self.machine.max_override, shares);
        let (bend, is_arc) = (bounds.second.norm(a.lead), matches!(curve, Curve::Arc { .. }));
        allowed = self.law.along(&allowed, bend, is_arc, self.most(), shares);
        if !self.direct && joints.is_none() {
            let speed = allowed.speed.min(1e-3);
            let (rest, top) = (allowed.rest.min(1e-3), allowed.at(speed).min(1e-3));
            allowed = Allowed::between(speed, rest, top);
        }
        if rapid < f64::INFINITY {
            // The override of a rapid move is a share of the speed that it has without one.
            rapid = rapid.min(self.law.fastest(&bounds, joints.as_ref()));
        }
        let (length, line) = (to - from, a.line);
        let [lead, linear] = lead_speeds(a, b);
        let mut raw = Raw {
            curve: number,
            from,
            length,
            allowed,
            feed: own,
            rapid,
            lead,
            linear,
            line,
            start: 0.0,
        };
        self.certificate.judge(&self.law, curve, joints.as_ref(), &mut raw);
        let time = self.law.reach();
        if self.erosion.waiting() >= MAX_WAITING {
            self.stop();
        }
        let raw = self.erosion.push(raw, time);
        if time > 0.0 {
            self.certificate.remember(&raw, time);
            self.drain(raw.end() - self.law.longest_reach());
        } else {
            self.drain(f64::INFINITY);
        }
    }

    /// Gives the cells before `frontier` to the track.
    pub(super) fn drain(&mut self, frontier: f64) {
        let time = self.law.reach();
        let samples = self.law.samples;
        let shortest = 0.1 * self.machine.period;
        let Self { erosion, certificate, track, window, machine, .. } = self;
        let mut give = |mut raw: Raw| {
            // The follower passes a bounded number of cells in a period.
            raw.allowed.speed = raw.allowed.speed.min(window.add(raw.length) / machine.period);
            if time > 0.0 {
                certificate.admit(&mut raw);
            }
            track.add_cell(Cell {
                curve: raw.curve,
                from: raw.from,
                length: raw.length,
                speed: raw.allowed.speed,
                feed: raw.feed,
                rapid: raw.rapid,
                lead: raw.lead,
                linear: raw.linear,
                rest: raw.allowed.rest,
                fade: raw.allowed.fade,
                end: 0.0,
                begin: 0.0,
                samples,
                stop: false,
                line: raw.line,
            });
        };
        if time > 0.0 {
            erosion.drain(frontier, shortest, give);
        } else {
            while let Some(raw) = erosion.pass() {
                give(raw);
            }
        }
    }
}

/// Returns the programmed speeds along a cell of a segment, or of a blend between two: of feed moves and of rapid moves.
/// The bounds are those of the cell, with the lead group of the first segment.
pub(super) fn programmed_along(
    curve: &Curve,
    [from, to]: [f64; 2],
    bounds: &Bounds,
    a: &Segment,
    b: Option<&Segment>,
) -> [f64; 2] {
    let mut speeds = [f64::INFINITY; 2];
    for (segment, speed) in leads(curve, [from, to], bounds, a, b).into_iter().flatten() {
        let [feed, rapid] = &mut speeds;
        let own = if segment.rapid { rapid } else { feed };
        *own = own.min(along(segment.feed, speed));
    }
    speeds
}

/// Returns the speed along a cell of a segment, or of a blend between two, for which corners are rounded.
pub(super) fn wanted_along(
    curve: &Curve,
    [from, to]: [f64; 2],
    bounds: &Bounds,
    a: &Segment,
    b: Option<&Segment>,
) -> f64 {
    wanted(leads(curve, [from, to], bounds, a, b).into_iter().flatten())
}

/// Returns the speed along a cell for which corners are rounded. With each segment goes the speed of its lead group along the
/// cell.
pub(super) fn wanted<'s>(segments: impl IntoIterator<Item = (&'s Segment, f64)>) -> f64 {
    let each = segments.into_iter().map(|(segment, speed)| along(segment.rounded_for, speed));
    each.fold(1e9, f64::min)
}

/// Returns each segment of a cell with the speed of its lead group along the cell.
fn leads<'s>(
    curve: &Curve,
    [from, to]: [f64; 2],
    bounds: &Bounds,
    a: &'s Segment,
    b: Option<&'s Segment>,
) -> [Option<(&'s Segment, f64)>; 2] {
    let next = b.map(|b| {
        let is_same = a.lead == b.lead;
        (b, if is_same { bounds.speed } else { curve.bounds(from, to, b.lead).speed })
    });
    [Some((a, bounds.speed)), next]
}

/// Returns the highest speed of the lead groups of a segment, or of a blend between two, at a speed of 1 along the path, and of
/// those whose unit is a length, rounded up.
fn lead_speeds(a: &Segment, b: Option<&Segment>) -> [f32; 2] {
    let mut speeds = [0.0_f64; 2];
    for segment in [Some(a), b].into_iter().flatten() {
        let [lead, linear] = &mut speeds;
        *lead = lead.max(segment.lead_speed);
        if segment.lead != Group::Abc {
            *linear = linear.max(segment.lead_speed);
        }
    }
    speeds.map(above)
}

/// Returns the lowest number of half the width that is not below this one.
#[expect(clippy::cast_possible_truncation, reason = "the next one is taken")]
fn above(exact: f64) -> f32 {
    let near = exact as f32;
    if f64::from(near) < exact { near.next_up() } else { near }
}

/// Returns the speed along a cell at which its lead group, of this speed along it, has a feed.
fn along(feed: f64, speed: f64) -> f64 {
    if speed > 0.0 { (feed / speed).min(1e9) } else { 1e9 }
}

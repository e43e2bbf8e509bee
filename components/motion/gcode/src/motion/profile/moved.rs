//! A profile moved by an allowance: the edge of what is below the profile or nearer to it than the allowance.
//!
//! In a frame in which the profile goes forward, this edge is the highest of some curves over the first axis: each
//! piece moved to its left, and the upper half of a circle round each corner. It is exact where pieces vanish, and where
//! a pocket is too narrow for the allowance.

use super::contour::{Arc, NEAR, Piece, SNAP};
use crate::motion::geometry::{Course, Point};

/// Lines between whose directions the cross product is smaller are parallel.
const PARALLEL: f64 = 1e-14;

/// Line or half of a circle that a curve follows.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Line(Point, Point),
    Circle { centre: Point, radius: f64, upper: bool },
}

/// A curve over an interval of the first axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Curve {
    low: f64,
    high: f64,
    shape: Shape,
}

impl Curve {
    /// Returns the upper half of the circle round a corner.
    fn round(corner: Point, radius: f64) -> Self {
        let shape = Shape::Circle { centre: corner, radius, upper: true };
        Self { low: corner.first - radius, high: corner.first + radius, shape }
    }

    /// Returns the curve of a piece; `None` if it stands upright.
    fn of(piece: &Piece) -> Option<Self> {
        let (from, to) = (piece.from, piece.to);
        let (from, to) = if from.first <= to.first { (from, to) } else { (to, from) };
        let shape = match piece.arc {
            None => Shape::Line(from, to),
            Some(Arc { centre, left }) => {
                Shape::Circle { centre, radius: piece.radius(), upper: !left }
            }
        };
        (to.first - from.first > NEAR).then_some(Self { low: from.first, high: to.first, shape })
    }

    fn height(&self, along: f64) -> f64 {
        match self.shape {
            Shape::Line(a, b) => {
                let share = (along - a.first) / (b.first - a.first);
                let share = if share > 1.0 { 1.0 } else { share.max(0.0) };
                a.second + share * (b.second - a.second)
            }
            Shape::Circle { centre, radius, upper } => {
                let way = along - centre.first;
                let square = (radius - way) * (radius + way);
                let half = if square > 0.0 { libm::sqrt(square) } else { 0.0 };
                centre.second + if upper { half } else { -half }
            }
        }
    }

    fn course(&self) -> Course {
        match self.shape {
            Shape::Line(a, b) => Course::Line(a, b.minus(a).unit().unwrap_or_default()),
            Shape::Circle { centre, radius, .. } => Course::Circle(centre, radius),
        }
    }

    /// Returns the places along the first axis at which two curves may cross.
    fn crossings(&self, other: &Self) -> Option<[f64; 2]> {
        let meetings = self.course().meetings(other.course(), PARALLEL);
        meetings.map(|[a, b]| [a.first, b.first])
    }

    /// Returns the piece of an edge.
    fn piece(&self) -> Piece {
        let at = |along: f64| Point::new(along, self.height(along));
        let arc = match self.shape {
            Shape::Line(..) => None,
            Shape::Circle { centre, upper, .. } => Some(Arc { centre, left: !upper }),
        };
        Piece { arc, ..Piece::straight(at(self.low), at(self.high)) }
    }
}

/// Returns a profile moved by `distance` to its left, in lines and arcs that go forward or stand upright.
pub(super) fn moved(pieces: &[Piece], distance: f64) -> Vec<Piece> {
    if libm::fabs(distance) < SNAP {
        return pieces.to_vec();
    }
    let exact: Vec<Piece> = pieces.iter().map(|p| p.exact()).collect();
    if distance > 0.0 {
        return edge(&exact, distance, true);
    }
    // The edge to the right is that of the mirror image to the left.
    let mirror = |p: &Piece| p.mapped(|p| Point::new(p.first, -p.second), true);
    let mirrored: Vec<Piece> = exact.iter().map(mirror).collect();
    edge(&mirrored, -distance, false).iter().map(mirror).collect()
}

/// Returns the edge above a profile. It begins above the begin of a profile that falls, if `round_begin` says so, and
/// else beside it.
fn edge(pieces: &[Piece], distance: f64, round_begin: bool) -> Vec<Piece> {
    let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else { return Vec::new() };
    let mut curves: Vec<Curve> = vec![Curve::round(first.from, distance)];
    for piece in pieces {
        curves.extend(piece.offset(distance).as_ref().and_then(Curve::of));
        curves.push(Curve::round(piece.to, distance));
    }
    let highest = highest(&curves);
    let aside = |piece: &Piece, at: Point| at.plus(piece.direction(at).left(), distance);
    let (mut begin, mut end) = (aside(first, first.from), aside(last, last.to));
    if round_begin && begin.first > first.from.first {
        begin.first = first.from.first;
    }
    end.first = end.first.max(begin.first);
    let level = |at: Point, side: f64| {
        let over = highest.iter().filter(|c| c.low < at.first + side && at.first + side < c.high);
        over.map(|c| c.height(at.first)).fold(at.second, f64::max)
    };
    begin.second = level(begin, -NEAR);
    end.second = level(end, NEAR);
    let mut out = Vec::new();
    let mut at = begin;
    for curve in &highest {
        let (low, high) = (curve.low.max(begin.first), curve.high.min(end.first));
        if low < high {
            add(&mut out, &mut at, Curve { low, high, ..*curve }.piece());
        }
    }
    add(&mut out, &mut at, Piece::straight(end, end));
    out
}

/// Adds a piece to an edge that has come to `at`, and what lies between.
fn add(out: &mut Vec<Piece>, at: &mut Point, mut piece: Piece) {
    if piece.from.minus(*at).length() >= SNAP {
        out.push(Piece::straight(*at, piece.from));
    } else {
        piece.from = *at;
    }
    *at = piece.from;
    if piece.to.minus(piece.from).length() >= SNAP {
        *at = piece.to;
        out.push(piece);
    }
}

/// Returns the highest of some curves wherever there is one, in order.
fn highest(curves: &[Curve]) -> Vec<Curve> {
    if curves.len() <= 1 {
        return curves.to_vec();
    }
    let (a, b) = curves.split_at(curves.len() / 2);
    higher(&highest(a), &highest(b))
}

/// Returns the higher of two courses of curves wherever there is one.
fn higher(mut a: &[Curve], mut b: &[Curve]) -> Vec<Curve> {
    let mut out = Vec::new();
    let mut along = f64::NEG_INFINITY;
    loop {
        while let Some((_, rest)) = a.split_first().filter(|(c, _)| c.high <= along) {
            a = rest;
        }
        while let Some((_, rest)) = b.split_first().filter(|(c, _)| c.high <= along) {
            b = rest;
        }
        let bound = |c: Option<&Curve>| {
            c.map_or(f64::INFINITY, |c| if c.low <= along { c.high } else { c.low })
        };
        let next = bound(a.first()).min(bound(b.first()));
        if next == f64::INFINITY {
            return out;
        }
        let over = |c: Option<&Curve>| c.filter(|c| c.low <= along).copied();
        match (over(a.first()), over(b.first())) {
            (Some(a), Some(b)) => choose(&mut out, a, b, along, next),
            (Some(c), None) | (None, Some(c)) => extend(&mut out, c, along, next),
            (None, None) => {}
        }
        along = next;
    }
}

/// Adds the higher of two curves between two places.
fn choose(out: &mut Vec<Curve>, a: Curve, b: Curve, low: f64, high: f64) {
    let mut cuts = [high; 3];
    for (cut, at) in cuts.iter_mut().zip(a.crossings(&b).into_iter().flatten()) {
        if low < at && at < high {
            *cut = at;
        }
    }
    cuts.sort_by(f64::total_cmp);
    let mut from = low;
    for to in cuts {
        if from < to {
            let middle = f64::midpoint(from, to);
            let curve = if a.height(middle) >= b.height(middle) { a } else { b };
            extend(out, curve, from, to);
        }
        from = to;
    }
}

fn extend(out: &mut Vec<Curve>, curve: Curve, low: f64, high: f64) {
    match out.last_mut() {
        Some(last) if last.high == low && last.shape == curve.shape => last.high = high,
        _ => out.push(Curve { low, high, ..curve }),
    }
}

//! The way of the tool in machine coordinates, in millimetres and degrees.

use core::f64::consts::{PI, TAU};
use hal_gcode::{
    Call,
    axis::{Axis, Position},
    canon::{ControlPoint, Frame, Plane, curve_point},
};

/// The kind of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A rapid move.
    Rapid,
    /// A move at feed.
    Feed,
}

/// The largest angle between two points of an arc, in radians.
const STEP: f64 = PI / 90.0;
/// The most points of one call.
const MAX_POINTS: f64 = 100_000.0;
/// The points of one control point of a curve.
const CURVE_POINTS: usize = 12;

/// Follows calls.
#[derive(Clone, Debug)]
pub struct Way {
    frame: Frame,
    /// The place, in machine coordinates of millimetres and degrees.
    pub at: Position,
}

impl Way {
    /// Begins at the place where the interpreter is.
    pub fn new(frame: Frame, position: Position) -> Self {
        Self { frame, at: frame.machine_mm(position) }
    }

    /// Returns the tool's offset, in millimetres and degrees.
    pub fn tool(&self) -> Position {
        self.frame.tool.scaled(self.frame.unit.millimetres())
    }

    /// Follows a call and hands out the points after the first of what it moves.
    pub fn follow(&mut self, call: &Call, each: &mut dyn FnMut(Kind, Position)) {
        self.frame.apply(call);
        match call {
            Call::StraightTraverse(end) => self.straight(Kind::Rapid, *end, each),
            Call::StraightFeed(end) | Call::StraightProbe { end, .. } => {
                self.straight(Kind::Feed, *end, each);
            }
            Call::RigidTap { end, .. } => {
                let back = self.at;
                self.straight(Kind::Feed, *end, each);
                self.at = back;
                each(Kind::Feed, back);
            }
            Call::ArcFeed { plane, end, centre_first, centre_second, turns } => {
                self.arc(*plane, *end, (*centre_first, *centre_second), *turns, each);
            }
            Call::NurbsFeed { order, points, end } => self.curve(*order, points, *end, each),
            _ => {}
        }
    }

    fn straight(&mut self, kind: Kind, end: Position, each: &mut dyn FnMut(Kind, Position)) {
        self.at = self.frame.machine_mm(end);
        each(kind, self.at);
    }

    /// Returns the place in program coordinates.
    fn program(&self) -> Position {
        self.frame.program(self.at.scaled(1.0 / self.frame.unit.millimetres()))
    }

    fn arc(
        &mut self,
        plane: Plane,
        end: Position,
        centre: (f64, f64),
        turns: i32,
        each: &mut dyn FnMut(Kind, Position),
    ) {
        let start = self.program();
        let (first, second, _) = plane.axes();
        let from = (start[first] - centre.0, start[second] - centre.1);
        let to = (end[first] - centre.0, end[second] - centre.1);
        let direction = if turns < 0 { -1.0 } else { 1.0 };
        let mut sweep = direction * (to.1.atan2(to.0) - from.1.atan2(from.0));
        while sweep <= 1e-9 {
            sweep += TAU;
        }
        sweep += TAU * f64::from(turns.unsigned_abs().saturating_sub(1));
        let begin = from.1.atan2(from.0);
        let (r0, r1) = (from.0.hypot(from.1), to.0.hypot(to.1));
        // The extremes of machine axes are points of their own.
        let turn = if plane == Plane::Xy { -self.frame.rotation.to_radians() } else { 0.0 };
        let mut angles = extremes(begin, direction, sweep, turn);
        let count = (sweep / STEP).ceil();
        let count = if count > MAX_POINTS { MAX_POINTS } else { count };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to MAX_POINTS"
        )]
        let whole = count as u32;
        angles.extend((1..whole).map(|i| sweep * f64::from(i) / count));
        angles.sort_by(f64::total_cmp);
        for angle in angles {
            let share = angle / sweep;
            let mut at = start.map(|axis, v| v + (end[axis] - v) * share);
            let radius = r0 + (r1 - r0) * share;
            let (sin, cos) = (begin + direction * angle).sin_cos();
            at[first] = centre.0 + radius * cos;
            at[second] = centre.1 + radius * sin;
            each(Kind::Feed, self.frame.machine_mm(at));
        }
        self.straight(Kind::Feed, end, each);
    }

    fn curve(
        &mut self,
        order: u32,
        points: &[ControlPoint],
        end: Position,
        each: &mut dyn FnMut(Kind, Position),
    ) {
        let start = self.program();
        let pieces = points.len().saturating_mul(CURVE_POINTS).min(100_000);
        for i in 1..pieces {
            let share = i as f64 / pieces as f64;
            if let Some((x, y)) = curve_point(order, points, share) {
                each(Kind::Feed, self.frame.machine_mm(Position { x, y, ..start }));
            }
        }
        self.straight(Kind::Feed, end, each);
    }
}

/// Returns the length of a straight move, in millimetres; in degrees if only rotary axes move.
pub fn distance(a: Position, b: Position) -> f64 {
    let d = b - a;
    let lines = (d.x * d.x + d.y * d.y + d.z * d.z + d.u * d.u + d.v * d.v + d.w * d.w).sqrt();
    // Where only rotary axes move, the feed counts degrees.
    if lines > 0.0 { lines } else { (d.a * d.a + d.b * d.b + d.c * d.c).sqrt() }
}

/// Returns the angles from the begin of an arc to the places where it is farthest along an axis.
fn extremes(begin: f64, direction: f64, sweep: f64, turn: f64) -> Vec<f64> {
    let mut out = Vec::new();
    for quarter in 0..4_u8 {
        let target = turn + f64::from(quarter) * PI / 2.0;
        let angle = (direction * (target - begin)).rem_euclid(TAU);
        // Later turns pass the same places.
        if angle < sweep {
            out.push(angle);
        }
    }
    out
}

/// The smallest box that holds points.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extents {
    /// Lowest coordinates.
    pub low: Position,
    /// Highest coordinates.
    pub high: Position,
    /// True once a point has been added.
    pub any: bool,
}

impl Extents {
    /// Returns the box that holds nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Widens the box to hold a point.
    pub fn add(&mut self, point: Position) {
        if !self.any {
            (self.low, self.high, self.any) = (point, point, true);
            return;
        }
        for axis in Axis::ALL {
            self.low[axis] = self.low[axis].min(point[axis]);
            self.high[axis] = self.high[axis].max(point[axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_gcode::canon::Unit;

    fn at(x: f64, y: f64) -> Position {
        Position { x, y, ..Position::default() }
    }

    fn extents(frame: Frame, start: Position, call: &Call) -> Extents {
        let mut way = Way::new(frame, start);
        let mut out = Extents::new();
        way.follow(call, &mut |_, p| out.add(p));
        out
    }

    #[test]
    fn an_arc_reaches_its_extremes_exactly() {
        let arc = |end, turns| Call::ArcFeed {
            plane: Plane::Xy,
            end,
            centre_first: 0.0,
            centre_second: 0.0,
            turns,
        };
        let mut frame = Frame::new(Unit::Inch);
        let quarter = extents(frame, at(0.6, 0.8), &arc(at(-0.6, 0.8), 1));
        assert!((quarter.high.y - 25.4).abs() < 1e-9 && (quarter.low.y - 20.32).abs() < 1e-9);
        let far = extents(frame, at(0.6, 0.8), &arc(at(-0.6, 0.8), -1));
        assert!((far.low.y + 25.4).abs() < 1e-9 && (far.high.y - 20.32).abs() < 1e-9);
        frame.rotation = 30.0;
        let whole = extents(frame, at(0.6, 0.8), &arc(at(0.6, 0.8), 3));
        assert!((whole.high.x - 25.4).abs() < 1e-9 && (whole.low.y + 25.4).abs() < 1e-9);
    }

    #[test]
    fn a_curve_of_weights_is_an_arc() {
        let point = |x, y, weight| ControlPoint { x, y, weight };
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let points = [point(1.0, 0.0, 1.0), point(1.0, 1.0, half), point(0.0, 1.0, 1.0)];
        for i in 0..=10 {
            let (x, y) = curve_point(3, &points, f64::from(i) / 10.0).unwrap();
            assert!((x.hypot(y) - 1.0).abs() < 1e-12, "{i}: {x} {y}");
        }
        let line: Vec<ControlPoint> = (0..6).map(|i| point(f64::from(i), 2.0, 1.0)).collect();
        assert_eq!(curve_point(2, &line, 0.5), Some((2.5, 2.0)));
        assert_eq!(curve_point(9, &line, 0.5), None);
    }
}

//! G2 and G3: arcs by centre or radius, in any plane.

use super::{geometry::Point, straight::length};
use crate::{
    axis::Position,
    canon::{Call, Plane, Unit},
    error::Problem,
    interpret::{Run, block::Block},
};

/// The difference of radii that is always allowed, in inches; a hundred times as much is never.
const SPIRAL_INCH: f64 = 0.002 * core::f64::consts::SQRT_2;
const SPIRAL_MM: f64 = 0.02 * core::f64::consts::SQRT_2;
/// The smallest radius of an arc by its centre, in inches.
const SMALLEST_INCH: f64 = 0.00005;
/// The allowed difference of radii as a part of the radius.
const SPIRAL_RELATIVE: f64 = 0.001;
/// The smallest and largest radius of an arc, in millimetres.
const RADII: core::ops::RangeInclusive<f64> = 1e-6..=1e9;

/// The words of a plane: the letters of its centre and the names of messages.
struct Letters {
    first: u8,
    second: u8,
    across: u8,
    ends: [u8; 2],
    plane: &'static str,
    missing: &'static str,
}

fn letters(plane: Plane) -> Letters {
    let make = |first, second, across, ends, plane, missing| Letters {
        first,
        second,
        across,
        ends,
        plane,
        missing,
    };
    match plane {
        Plane::Xy => make(b'i', b'j', b'k', *b"xy", "XY", "X and y"),
        Plane::Xz => make(b'k', b'i', b'j', *b"zx", "XZ", "X and z"),
        Plane::Yz => make(b'j', b'k', b'i', *b"yz", "YZ", "Y and z"),
        Plane::Uv => make(b'i', b'j', b'k', *b"uv", "UV", "U and v"),
        Plane::Uw => make(b'k', b'i', b'j', *b"wu", "UW", "U and w"),
        Plane::Vw => make(b'j', b'k', b'i', *b"vw", "VW", "V and w"),
    }
}

/// The shape of an arc in its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) centre: Point,
    /// Turns, negative for clockwise; 1 is the arc itself.
    pub(crate) turns: i32,
}

/// Returns the coordinates of a position in a plane.
pub(crate) fn in_plane(plane: Plane, position: Position) -> Point {
    let (first, second, _) = plane.axes();
    Point::new(position[first], position[second])
}

/// Returns the position with other coordinates in a plane.
pub(crate) fn with_plane(plane: Plane, mut position: Position, at: Point) -> Position {
    let (first, second, _) = plane.axes();
    position[first] = at.first;
    position[second] = at.second;
    position
}

/// Returns the angle of an arc in radians, above zero.
pub(crate) fn sweep(start: Point, end: Point, shape: Shape) -> f64 {
    let (a, b) = (start.minus(shape.centre), end.minus(shape.centre));
    let mut angle = libm::atan2(a.cross(b), a.dot(b));
    if shape.turns < 0 {
        angle = -angle;
    }
    // Motion takes an end within rounding of the start for a full turn, too.
    if angle < 1e-7 {
        angle += core::f64::consts::TAU;
    }
    angle + core::f64::consts::TAU * f64::from(shape.turns.unsigned_abs().saturating_sub(1))
}

impl Run<'_> {
    pub(super) fn arc(&mut self, b: &Block, clockwise: bool) -> Result<(), Problem> {
        self.check_feed(b, "arc")?;
        if self.state.compensation.ended {
            return Err(Problem::CompEndArc);
        }
        let plane = self.state.modal.plane;
        match plane {
            Plane::Xy | Plane::Xz | Plane::Yz if b.has_any(b"uvw") => return Err(Problem::ArcUvw),
            Plane::Uv | Plane::Uw | Plane::Vw if b.has_any(b"xyz") => return Err(Problem::ArcXyz),
            _ => {}
        }
        let end = self.target(b)?;
        let from = self.programmed();
        let (start, stop) = (in_plane(plane, from), in_plane(plane, end));
        let shape = self.shape(b, start, stop, clockwise)?;
        if self.state.compensation.moves_path() {
            return self.compensated_arc(b, end, shape);
        }
        let plane_length = start.minus(shape.centre).length() * sweep(start, stop, shape);
        let (_, _, along) = plane.axes();
        let total = libm::hypot(plane_length, end[along] - from[along]);
        self.inverse_feed(b, if total > 0.0 { total } else { length(from, end) })?;
        self.emit_arc(end, shape)?;
        self.state.position = end;
        Ok(())
    }

    pub(crate) fn emit_arc(&mut self, end: Position, shape: Shape) -> Result<(), Problem> {
        self.emit(Call::ArcFeed {
            plane: self.state.modal.plane,
            end,
            centre_first: shape.centre.first,
            centre_second: shape.centre.second,
            turns: shape.turns,
        })
    }

    /// Returns the shape of the arc of a block.
    pub(super) fn shape(
        &self,
        b: &Block,
        start: Point,
        end: Point,
        clockwise: bool,
    ) -> Result<Shape, Problem> {
        let l = letters(self.state.modal.plane);
        let turns = match b.get(b'p') {
            None => 1,
            Some(p) => crate::text::evaluate::integer(p).map_err(|_| Problem::TurnsNotInteger)?,
        };
        let turns = if clockwise { -turns } else { turns };
        if b.has(l.across) {
            return Err(Problem::ArcWordPlane { letter: upper(l.across), plane: l.plane });
        }
        if let Some(r) = b.get(b'r') {
            if b.has_any(b"ijk") {
                return Err(Problem::ArcMixed);
            }
            if !b.has_any(&l.ends) && !b.has_any(b"@^") {
                return Err(Problem::ArcEndMissing { words: l.missing, plane: l.plane });
            }
            let centre = self.centre_of_radius(start, end, r, clockwise)?;
            self.check_size(start, centre)?;
            return Ok(Shape { centre, turns });
        }
        let (first, second) = (b.get(l.first), b.get(l.second));
        let centre = match (self.state.modal.ijk_absolute, first, second) {
            (_, None, None) => return Err(Problem::ArcWordsMissing { words: "R i j k" }),
            (true, Some(first), Some(second)) => Point::new(first, second),
            (true, None, _) => return Err(Problem::ArcBothCentre { letter: upper(l.first) }),
            (true, ..) => return Err(Problem::ArcBothCentre { letter: upper(l.second) }),
            (false, ..) => start.plus(Point::new(first.unwrap_or(0.0), second.unwrap_or(0.0)), 1.0),
        };
        self.check_radii(start, end, centre)?;
        self.check_size(start, centre)?;
        Ok(Shape { centre, turns })
    }

    /// Checks that a radius is one that a machine can follow.
    fn check_size(&self, start: Point, centre: Point) -> Result<(), Problem> {
        let radius = start.minus(centre).length() * self.state.frame.unit.millimetres();
        if RADII.contains(&radius) { Ok(()) } else { Err(Problem::ArcSize) }
    }

    /// Returns the centre of an arc by its radius; the long way round for a negative one.
    fn centre_of_radius(
        &self,
        start: Point,
        end: Point,
        r: f64,
        clockwise: bool,
    ) -> Result<Point, Problem> {
        let chord = end.minus(start);
        let Some(direction) = chord.unit() else { return Err(Problem::ArcSamePlace) };
        let half = chord.length() / 2.0;
        let mut radius = libm::fabs(r);
        if half > radius {
            let allowed = match self.state.frame.unit {
                Unit::Inch => SPIRAL_INCH / 10.0,
                Unit::Millimetre => SPIRAL_MM / 10.0,
            };
            if half - radius > allowed {
                return Err(Problem::ArcRadiusSmall);
            }
            radius = half;
        }
        let height = libm::sqrt(radius * radius - half * half);
        let to_left = if clockwise == (r < 0.0) { height } else { -height };
        Ok(start.plus(chord, 0.5).plus(direction.left(), to_left))
    }

    fn check_radii(&self, start: Point, end: Point, centre: Point) -> Result<(), Problem> {
        let (r1, r2) = (start.minus(centre).length(), end.minus(centre).length());
        let unit = self.state.frame.unit;
        let absolute = match unit {
            _ if self.state.is_rs274d() => self.state.settings.arc_tolerance / unit.millimetres(),
            Unit::Inch => SPIRAL_INCH,
            Unit::Millimetre => SPIRAL_MM,
        };
        let (f, s, _) = self.state.modal.plane.axes();
        let (f, s) = (f.letter().to_ascii_uppercase(), s.letter().to_ascii_uppercase());
        let at = |p: Point| format!("({f}{:.4},{s}{:.4})", p.first, p.second);
        let places = || format!("start={} center={} end={}", at(start), at(centre), at(end));
        let smallest = match unit {
            _ if self.state.is_rs274d() => absolute / 20.0,
            Unit::Inch => SMALLEST_INCH,
            Unit::Millimetre => SMALLEST_INCH * 25.4,
        };
        if r1 < smallest || r2 < smallest {
            let detail = format!("{} r1={r1:.4} r2={r2:.4}", places());
            return Err(Problem::ArcRadiusZero { detail: detail.into() });
        }
        let error = libm::fabs(r1 - r2);
        let relative = error / if r1 > r2 { r1 } else { r2 };
        if error > 100.0 * absolute || (relative > SPIRAL_RELATIVE && error > absolute) {
            let detail = format!(
                "{} r1={r1:.4} r2={r2:.4} abs_err={} rel_err={:.4}%",
                places(),
                four_digits(error),
                relative * 100.0
            );
            return Err(Problem::ArcRadiiDiffer { detail: detail.into() });
        }
        Ok(())
    }
}

fn upper(letter: u8) -> char {
    char::from(letter.to_ascii_uppercase())
}

/// Returns a positive value with at most four significant digits.
fn four_digits(value: f64) -> String {
    let mut digits = 3usize;
    let mut scaled = value;
    while scaled < 1.0 && digits < 12 {
        scaled *= 10.0;
        digits += 1;
    }
    while scaled >= 10.0 && digits > 0 {
        scaled /= 10.0;
        digits -= 1;
    }
    let text = format!("{value:.digits$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

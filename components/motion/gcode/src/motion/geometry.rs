//! Plane geometry of compensation and profiles.

use serde::{Deserialize, Serialize};

/// A point or vector of a plane, in the order of its axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Along the first axis.
    pub first: f64,
    /// Along the second axis.
    pub second: f64,
}

impl Point {
    pub(crate) fn new(first: f64, second: f64) -> Self {
        Self { first, second }
    }

    pub(crate) fn plus(self, other: Self, factor: f64) -> Self {
        Self::new(self.first + factor * other.first, self.second + factor * other.second)
    }

    pub(crate) fn minus(self, other: Self) -> Self {
        self.plus(other, -1.0)
    }

    pub(crate) fn length(self) -> f64 {
        libm::hypot(self.first, self.second)
    }

    pub(crate) fn dot(self, other: Self) -> f64 {
        self.first * other.first + self.second * other.second
    }

    pub(crate) fn cross(self, other: Self) -> f64 {
        self.first * other.second - self.second * other.first
    }

    /// Returns the vector turned by a quarter to the left.
    pub(crate) fn left(self) -> Self {
        Self::new(-self.second, self.first)
    }

    /// Returns the vector with length 1, or `None` for no length.
    pub(crate) fn unit(self) -> Option<Self> {
        let length = self.length();
        (length > 0.0 && length.is_finite())
            .then(|| Self::new(self.first / length, self.second / length))
    }
}

/// A line or a circle, whole.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Course {
    /// Through a point, in a unit direction.
    Line(Point, Point),
    /// Round a centre, with a radius.
    Circle(Point, f64),
}

impl Course {
    /// Returns the meeting points with another course; twice the same of two lines, and none of lines between whose directions
    /// the cross product is below `parallel`.
    pub(crate) fn meetings(self, other: Self, parallel: f64) -> Option<[Point; 2]> {
        match (self, other) {
            (Self::Line(a, along), Self::Line(b, across)) => {
                let cross = along.cross(across);
                if libm::fabs(cross) < parallel {
                    return None;
                }
                let at = a.plus(along, b.minus(a).cross(across) / cross);
                Some([at, at])
            }
            (Self::Line(at, along), Self::Circle(centre, radius))
            | (Self::Circle(centre, radius), Self::Line(at, along)) => {
                line_circle(at, along, centre, radius)
            }
            (Self::Circle(a, ra), Self::Circle(b, rb)) => circles(a, ra, b, rb),
        }
    }
}

/// Returns the meeting points of a line (a point and a unit direction) and a circle.
fn line_circle(at: Point, direction: Point, centre: Point, radius: f64) -> Option<[Point; 2]> {
    let foot = at.plus(direction, centre.minus(at).dot(direction));
    let distance = foot.minus(centre).length();
    let square = radius * radius - distance * distance;
    if square < 0.0 {
        return None;
    }
    let half = libm::sqrt(square);
    Some([foot.plus(direction, half), foot.plus(direction, -half)])
}

/// Returns the meeting points of two circles.
fn circles(a: Point, ra: f64, b: Point, rb: f64) -> Option<[Point; 2]> {
    let between = b.minus(a);
    let d = between.length();
    let direction = between.unit()?;
    let along = (d * d + ra * ra - rb * rb) / (2.0 * d);
    let square = ra * ra - along * along;
    if square < 0.0 {
        return None;
    }
    let foot = a.plus(direction, along);
    let half = libm::sqrt(square);
    Some([foot.plus(direction.left(), half), foot.plus(direction.left(), -half)])
}

/// Returns the nearer of two points.
pub(crate) fn nearest(points: [Point; 2], to: Point) -> Point {
    let [a, b] = points;
    if a.minus(to).length() <= b.minus(to).length() { a } else { b }
}

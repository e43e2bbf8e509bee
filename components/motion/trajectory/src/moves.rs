//! Programmed moves, and their check at the door.

use crate::{
    bounds::cross,
    curve::Curve,
    error::Error,
    pose::{FARTHEST, Group, Pose},
    segment::Segment,
};

/// Shortest displacement that is a move of its own; shorter ones become part of the next move.
pub const SHORTEST: f64 = 1e-9;

/// Lowest feed, in units per second.
const SLOWEST: f64 = 1e-6;

/// XYZ (or UVW) displacement below this share of the rotary travel counts as zero for the feed.
const LINEAR_SHARE: f64 = 1e-6;

/// Largest difference between the radii at both ends of an arc, as a share of the radius, and in length units. A smaller
/// difference is spread over the arc.
const RADIUS_SHARE: f64 = 1e-3;
const RADIUS_DIFFERENCE: f64 = 0.01;

/// A programmed move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Shape of the path.
    pub shape: Shape,
    /// Feed in units per second, along XYZ; without XYZ motion along UVW; else in degrees per second along ABC.
    /// Infinity moves as fast as the limits allow.
    pub feed: f64,
    /// True for a rapid move: the rapid override scales its speed, not the feed override.
    pub rapid: bool,
    /// Path control at the end of the move.
    pub mode: Mode,
    /// Line of the program.
    pub line: u32,
}

/// Shape of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight line in all axes.
    Line {
        /// End.
        end: Pose,
    },
    /// An arc, helix or full circle in XYZ; all other axes move linearly.
    Arc {
        /// End.
        end: Pose,
        /// Centre, at any height along the axis.
        center: [f64; 3],
        /// Direction of the axis; the motion is counter-clockwise around it. Any length.
        normal: [f64; 3],
        /// Additional full turns. An arc that ends where it starts is one turn.
        turns: u32,
    },
}

/// Path control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// The motion comes to rest at the end of the move (G61.1).
    ExactStop,
    /// The motion stays within the machine's exact tolerance of the path (G61, G64 P0).
    Exact,
    /// The motion stays within this distance of the path, in XYZ and in UVW each (G64 P).
    Blend(f64),
}

impl Move {
    /// Checks the move and converts it; `None` is a move too short to be one.
    pub(crate) fn segment(&self, start: &Pose) -> Result<Option<Segment>, Error> {
        let line = self.line;
        check(self.feed, self.mode, line)?;
        let shaped = match &self.shape {
            Shape::Line { end } => {
                if !end.is_usable() {
                    return Err(Error::NotFinite { line });
                }
                straight(start, end)
            }
            Shape::Arc { end, center, normal, turns } => {
                let numbers = center.iter().all(|x| x.abs() <= FARTHEST)
                    && normal.iter().all(|x| x.abs() <= FARTHEST);
                if !end.is_usable() || !numbers {
                    return Err(Error::NotFinite { line });
                }
                Some(round(start, end, center, normal, *turns, line)?)
            }
        };
        Ok(shaped.map(|Shaped { curve, length, lead, main, lead_speed }| Segment {
            curve,
            length,
            lead,
            main,
            lead_speed,
            feed: self.feed.min(1e9),
            rounded_for: self.feed.min(1e9),
            rapid: self.rapid,
            mode: self.mode,
            line,
            smooth: false,
            off: 0.0,
        }))
    }
}

/// Refuses feeds and modes that are none.
pub(crate) fn check(feed: f64, mode: Mode, line: u32) -> Result<(), Error> {
    if feed.is_nan() || feed < SLOWEST {
        return Err(Error::Feed { line, feed });
    }
    if let Mode::Blend(tolerance) = mode
        && (tolerance.is_nan() || tolerance < 0.0)
    {
        return Err(Error::Tolerance { line, tolerance });
    }
    Ok(())
}

/// Returns the group with the longest of three travels, and the group that governs the feed.
pub(crate) fn lead([xyz, abc, uvw]: [f64; 3]) -> (Group, Group) {
    let lead = if xyz > LINEAR_SHARE * abc && xyz > LINEAR_SHARE * uvw {
        Group::Xyz
    } else if uvw > LINEAR_SHARE * abc {
        Group::Uvw
    } else {
        Group::Abc
    };
    let longest = xyz.max(abc).max(uvw);
    let all = Group::ALL.into_iter().zip([xyz, abc, uvw]);
    let main = all.into_iter().find(|(_, l)| *l >= longest).map_or(lead, |(group, _)| group);
    (main, lead)
}

/// A curve with its length in the path coordinate, and its groups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shaped {
    pub(crate) curve: Curve,
    pub(crate) length: f64,
    /// Group that governs the feed.
    pub(crate) lead: Group,
    /// Group in which places on the path are compared.
    pub(crate) main: Group,
    /// Speed of the group that governs the feed, at a speed of 1 along the path.
    pub(crate) lead_speed: f64,
}

/// Returns the line between two poses. The path coordinate is the longest of the travels in the three groups, so that no
/// derivative exceeds 1.
pub(crate) fn straight(start: &Pose, end: &Pose) -> Option<Shaped> {
    let by = *end - *start;
    let (xyz, abc, uvw) = (by.norm(Group::Xyz), by.norm(Group::Abc), by.norm(Group::Uvw));
    let (main, lead) = lead([xyz, abc, uvw]);
    let length = xyz.max(abc).max(uvw);
    if length < SHORTEST {
        return None;
    }
    Some(Shaped {
        curve: Curve::Line { start: *start, slope: by * (1.0 / length) },
        length,
        lead,
        main,
        lead_speed: if lead == main { 1.0 } else { by.norm(lead) / length },
    })
}

/// Returns an arc or helix. The path coordinate is the length in XYZ, or the travel of another group if that is longer.
fn round(
    start: &Pose,
    end: &Pose,
    center: &[f64; 3],
    normal: &[f64; 3],
    turns: u32,
    line: u32,
) -> Result<Shaped, Error> {
    let size = dot(normal, normal).sqrt();
    if size <= 1e-12 {
        return Err(Error::NoRadius { line });
    }
    let axis = normal.map(|x| x / size);
    let from = sub(&start.group(Group::Xyz), center);
    let to = sub(&end.group(Group::Xyz), center);
    let (low, high) = (dot(&from, &axis), dot(&to, &axis));
    let arm = minus(&from, &axis, low);
    let last = minus(&to, &axis, high);
    let (r0, r1) = (dot(&arm, &arm).sqrt(), dot(&last, &last).sqrt());
    if r0 <= SHORTEST || r1 <= SHORTEST {
        return Err(Error::NoRadius { line });
    }
    if (r0 - r1).abs() > RADIUS_DIFFERENCE.min(RADIUS_SHARE * r0) {
        return Err(Error::RadiiDiffer { line, start: r0, end: r1 });
    }
    let side = cross(&axis, &arm);
    let mut angle = libm::atan2(dot(&last, &side), dot(&last, &arm));
    // An end within rounding of the start is a full turn.
    if angle < 1e-7 {
        angle += core::f64::consts::TAU;
    }
    angle += core::f64::consts::TAU * f64::from(turns);
    let rise = high - low;
    let flat = angle * r0;
    let length = (flat * flat + rise * rise).sqrt();
    let rate = angle / length;
    let middle = Pose::from_xyz(sub(&start.group(Group::Xyz), &arm));
    let mut rest = *start;
    for x in rest.0.iter_mut().take(3) {
        *x = 0.0;
    }
    let origin = middle + rest;
    let whole = Curve::Arc { center: origin, arm, side, rate, drift: Pose::ZERO };
    // Linear motion takes up the rise, the other axes, and the difference of the radii.
    let drift = (*end - whole.pose(length)) * (1.0 / length);
    let by = *end - *start;
    let others = by.norm(Group::Abc).max(by.norm(Group::Uvw));
    let lead = if length > LINEAR_SHARE * others { Group::Xyz } else { Group::Abc };
    let k = (length / others).min(1.0);
    let curve = Curve::Arc { center: origin, arm, side, rate: rate * k, drift: drift * k };
    let lead_speed = if lead == Group::Xyz { k } else { by.norm(lead) / others };
    Ok(Shaped { curve, length: length.max(others), lead, main: Group::Xyz, lead_speed })
}

const fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

const fn sub(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns `a` without its part along `axis`.
const fn minus(a: &[f64; 3], axis: &[f64; 3], part: f64) -> [f64; 3] {
    [a[0] - axis[0] * part, a[1] - axis[1] * part, a[2] - axis[2] * part]
}

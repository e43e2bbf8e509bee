//! Refusals: input that the planner does not accept.

use crate::pose::Pose;
use core::fmt;

/// A move, limit or setting that is refused, with the values involved.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A coordinate is NaN, infinite or beyond the largest coordinate.
    NotFinite {
        /// Line of the program.
        line: u32,
    },
    /// The feed is not a number from 1e-6 up.
    Feed {
        /// Line of the program.
        line: u32,
        /// Feed, in units per second.
        feed: f64,
    },
    /// A blend tolerance is negative or NaN.
    Tolerance {
        /// Line of the program.
        line: u32,
        /// Tolerance, in length units.
        tolerance: f64,
    },
    /// The start and the end of an arc have different distances from its centre.
    RadiiDiffer {
        /// Line of the program.
        line: u32,
        /// Radius at the start.
        start: f64,
        /// Radius at the end.
        end: f64,
    },
    /// An arc has a radius of zero, or an axis without direction.
    NoRadius {
        /// Line of the program.
        line: u32,
    },
    /// A limit is zero, negative, NaN or below 1e-6.
    Limit {
        /// Letter or number of the axis or joint: 0 to 8 are axes, 100 and above are joints.
        index: usize,
        /// Value of the limit.
        value: f64,
    },
    /// The servo period or a tolerance of the machine is not a positive number, or is below rounding.
    Setting {
        /// Value of the setting.
        value: f64,
    },
    /// The kinematics has no joint positions for a pose on the path.
    Unreachable {
        /// Line of the program.
        line: u32,
        /// Joint that has no position.
        joint: usize,
        /// Pose without a joint position, one of perhaps many.
        place: Pose,
    },
    /// Near a singularity, a joint would allow less than a hundredth of the feed.
    Singular {
        /// Line of the program.
        line: u32,
        /// Joint that limits the speed.
        joint: usize,
    },
    /// A B-spline or NURBS cannot be a move.
    Spline {
        /// Line of the program.
        line: u32,
        /// Reason.
        fault: SplineFault,
    },
    /// The track is full; the move was not taken. Let the follower advance, then repeat it.
    Full,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite { line } => {
                write!(f, "line {line}: a coordinate is not a number up to 1e9")
            }
            Self::Feed { line, feed } => {
                write!(f, "line {line}: feed {feed} is not a number from 1e-6 up")
            }
            Self::Tolerance { line, tolerance } => {
                write!(f, "line {line}: tolerance {tolerance} is not a number from 0 up")
            }
            Self::RadiiDiffer { line, start, end } => {
                write!(f, "line {line}: radius to start is {start}, radius to end is {end}")
            }
            Self::NoRadius { line } => {
                write!(f, "line {line}: the arc has no radius or its axis no direction")
            }
            Self::Limit { index, value } if *index >= 100 => {
                write!(f, "joint {}: limit {value} is not a number from 1e-6 up", index - 100)
            }
            Self::Limit { index, value } => {
                let letter = "XYZABCUVW".chars().nth(*index).unwrap_or('?');
                write!(f, "axis {letter}: limit {value} is not a number from 1e-6 up")
            }
            Self::Setting { value } => write!(f, "setting {value} is outside its range"),
            Self::Unreachable { line, joint, place } => {
                write!(f, "line {line}: joint {joint} has no position for a pose on the path, at")?;
                for (k, (letter, x)) in "XYZABCUVW".chars().zip(place.0).enumerate() {
                    if k < 3 || x != 0.0 {
                        write!(f, " {letter}{x:.4}")?;
                    }
                }
                Ok(())
            }
            Self::Singular { line, joint } => {
                write!(
                    f,
                    "line {line}: singularity: joint {joint} allows less than 1 % of the feed"
                )
            }
            Self::Spline { line, fault } => write!(f, "line {line}: spline: {fault}"),
            Self::Full => write!(f, "the track is full"),
        }
    }
}

impl core::error::Error for Error {}

/// Reason for which a B-spline or NURBS is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SplineFault {
    /// The degree is neither two nor three.
    Degree,
    /// The numbers of knots and control points do not fit.
    Count,
    /// A control point is NaN or beyond [`FARTHEST`](crate::FARTHEST), or a weight is not positive or more than 1e6 times
    /// another.
    Weight,
    /// Knots fall, are NaN or beyond 1e9, or more of them than the degree are equal inside the curve.
    Knots,
    /// The curve does not start where the move before ends.
    Start,
    /// The curve or a part of it has no length.
    Short,
    /// The curve bends too sharply to be approximated inside the tolerance.
    Sharp,
    /// The curve has too many parts.
    Long,
}

impl fmt::Display for SplineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Degree => "the degree is neither 2 nor 3",
            Self::Count => "there must be as many knots as control points, and degree + 1 more",
            Self::Weight => {
                "a control point is out of range, or a weight is not positive or too unequal"
            }
            Self::Knots => {
                "knots fall, are out of range, or more of them than the degree are equal"
            }
            Self::Start => "it does not start where the move before ends",
            Self::Short => "a part of it has no length",
            Self::Sharp => "it bends too sharply for the tolerance",
            Self::Long => "it has too many parts for one move",
        })
    }
}

impl core::error::Error for SplineFault {}

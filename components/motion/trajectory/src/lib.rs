//! Paths of thousands of lines and arcs at speed, inside limits that hold.
//!
//! Several parts work together:
//!
//! - The [`Planner`] turns moves into a [`Track`]: curves with continuous first and second derivatives inside the path
//!   tolerance, cut into cells with the highest speed and acceleration that every axis and joint allows.
//! - The [`Follower`] walks along the track in the servo thread, at any override of feeds and of rapid moves, holds, and
//!   reverses. A moving average over its travel limits the jerk. The average moves the output along the path, never off it.
//! - The [`Pursuer`] follows a spindle along such a track instead, without the delay of an average.
//! - A certificate checks each cell, by other means than the plan, before the follower may see it.
//!
//! ```
//! use hal_trajectory::{Follower, Limits, Machine, Mode, Move, Planner, Pose, Shape, Trivial};
//!
//! let limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 };
//! let machine = Machine::uniform(limits);
//! let mut planner = Planner::new(machine, Trivial, Pose::ZERO)?;
//! for (line, (x, y)) in [(50.0, 0.0), (50.0, 30.0), (0.0, 30.0)].into_iter().enumerate() {
//!     let shape = Shape::Line { end: Pose::from_xyz([x, y, 0.0]) };
//!     let mode = Mode::Blend(0.1);
//!     planner.push(&Move { shape, feed: 100.0, rapid: false, mode, line: line as u32 })?;
//! }
//! planner.finish();
//!
//! let mut follower = Follower::new(machine.period, Pose::ZERO);
//! let mut periods = 0;
//! while !follower.is_done(planner.track()) {
//!     let step = follower.step(planner.track(), 1.0, false);
//!     assert!(step.pose.0[0] <= 50.0 + 1e-9);
//!     periods += 1;
//! }
//! // 130 mm at 100 mm/s take 1300 ms; the two corners, start, stop and the limit of jerk take the rest.
//! assert_eq!(periods, 1_570);
//! # Ok::<(), hal_trajectory::Error>(())
//! ```
#![forbid(unsafe_code)]

mod axis;
mod blend;
mod bounds;
mod certificate;
mod chaser;
mod curve;
mod erosion;
mod error;
mod follower;
mod join;
mod kinematics;
mod lead;
mod machine;
mod moves;
mod plan;
mod pose;
mod pursuer;
mod scales;
mod segment;
mod share;
mod slots;
mod speed;
mod sync;
mod tops;
mod track;

pub use axis::{Axis, Goal};
pub use bounds::Bounds;
pub use certificate::{Rejection, Rule};
pub use chaser::{Aim, Chaser, Rates};
pub use curve::{Curve, Derivatives};
pub use error::{Error, SplineFault};
pub use follower::{Follower, Step};
pub use kinematics::{Jet, Joints, Kinematics, Trivial};
pub use machine::{JOINTS, Limits, Machine};
pub use moves::{Mode, Move, SHORTEST, Shape};
pub use plan::{CAPACITY, Deviation, Planner, spline::Spline};
pub use pose::{AXES, FARTHEST, Group, Pose};
pub use pursuer::{Pursuer, Pursuit};
pub use scales::Scales;
pub use share::{Publisher, Reader, share};
pub use tops::Tops;
pub use track::{Cell, Path, Track};

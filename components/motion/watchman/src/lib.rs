//! An independent judge of motion.
//!
//! The watchman sees positions at a fixed period and nothing else. It judges the velocity, acceleration and jerk of
//! each joint by finite differences ([`Watchman`]), and the distance from the programmed path ([`PathWatch`]). It
//! shares no code with any planner, allocates nothing in a step, and keeps the worst of each value with the cycle and
//! the program line.
//!
//! # Sampling
//! The n-th finite difference of a sampled position, divided by the n-th power of the period, is a weighted mean of the
//! n-th derivative over n periods. A motion whose derivatives obey the limits at every instant therefore obeys
//! them in every difference: the watchman never reports such a motion. A peak that is shorter than a period can
//! pass below the limit; a drive that receives the same samples does not see that peak either.
//!
//! # Rounding
//! A position computed in double precision is off by at most `ROUNDINGS · 2⁻⁵³ · size`, where `size` is the
//! largest quantity in that computation: a coordinate, a radius or a length. Differences of order 1, 2 and 3 weigh
//! such errors with 2, 4 and 8. Exactly these amounts are subtracted before the comparison with the limit, so a ratio
//! above 1 is a violation and no matter of rounding. At 1000 mm and 1 ms the allowance for jerk is 0.007 mm/s³.
#![forbid(unsafe_code)]

mod joints;
mod path;
mod shape;
mod spline;
#[cfg(test)]
mod tests;

pub use joints::{Limits, ROUNDINGS, Report, Watchman, Worst};
pub use path::{PathWatch, Tolerance};
pub use shape::{AXES, Shape};
pub use spline::Spline;

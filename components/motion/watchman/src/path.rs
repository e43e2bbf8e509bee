//! Realtime. Judges the distance of the pose from the programmed path.

use crate::{
    joints::{ROUNDINGS, Worst},
    shape::{AXES, Shape},
};

/// Allowed distance from the path around one shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// In XYZ and in UVW each, in length units.
    pub linear: f64,
    /// In ABC, in degrees.
    pub angular: f64,
}

/// Judge of the distance from a path. The path is given before motion starts; a step allocates nothing.
#[derive(Clone, Debug)]
pub struct PathWatch {
    shapes: Box<[(Shape, Tolerance)]>,
    size: f64,
    reach: usize,
    worst: Worst,
    violations: u64,
    cycles: u64,
}

/// Number of neighbours on either side that are examined when the near ones are too far from the pose.
const FAR: usize = 2048;

impl PathWatch {
    /// Judge for these shapes. Each step examines the shape of the hint, and only if the pose is too far from it, its
    /// neighbours, `reach` shapes on either side, and more of them before it reports a violation. `size` has the meaning
    /// that it has in [`crate::Watchman::new`].
    pub fn new(shapes: Box<[(Shape, Tolerance)]>, size: f64, reach: usize) -> Self {
        Self { shapes, size, reach, worst: Worst::default(), violations: 0, cycles: 0 }
    }

    /// Judges one pose; `near` is the number of a shape in its neighbourhood. A wrong hint can only enlarge the
    /// distance that is found. Returns false if the pose is too far from the path.
    pub fn step(&mut self, pose: &[f64; AXES], near: usize) -> bool {
        // Every search finds an upper bound of the true ratio; the first one inside the tolerance suffices.
        let searches =
            [(0, false), (1, false), (self.reach, false), (self.reach, true), (FAR, true)];
        let mut ratio = f64::INFINITY;
        for (reach, exact) in searches {
            ratio = ratio.min(self.least(pose, near, reach, exact, 1.0));
            if ratio <= 1.0 {
                break;
            }
        }
        let line = u32::try_from(near).unwrap_or(u32::MAX);
        self.worst.raise(Worst { ratio, cycle: self.cycles, joint: 0, line });
        self.cycles = self.cycles.wrapping_add(1);
        let good = ratio <= 1.0;
        if !good {
            self.violations = self.violations.wrapping_add(1);
        }
        good
    }

    /// Returns the largest ratio of distance to tolerance that was found so far, and its place. A value up to 1 may be
    /// larger than the true one, because the search ends at the first shape that is near enough.
    pub const fn worst(&self) -> &Worst {
        &self.worst
    }

    /// Returns the ratio of distance to tolerance: the least one over the shapes within `reach` of `near`, below 1 too;
    /// infinity if the pose is not finite.
    pub fn ratio(&self, pose: &[f64; AXES], near: usize, reach: usize) -> f64 {
        self.least(pose, near, reach, true, 0.0)
    }

    /// Returns the number of cycles in which the pose was too far from the path.
    pub const fn violations(&self) -> u64 {
        self.violations
    }

    /// Least ratio of distance to tolerance over the shapes within `reach` of `near`; infinity if the pose is not finite.
    /// The search along a spline ends at `enough`.
    fn least(
        &self,
        pose: &[f64; AXES],
        near: usize,
        reach: usize,
        exact: bool,
        enough: f64,
    ) -> f64 {
        let first = near.saturating_sub(reach);
        let count = near.saturating_add(reach).saturating_add(1).saturating_sub(first);
        let mut least = f64::INFINITY;
        if !pose.iter().all(|x| x.is_finite()) {
            return least;
        }
        for (shape, tolerance) in self.shapes.iter().skip(first).take(count) {
            let error = 4.0 * ROUNDINGS * f64::EPSILON * self.size;
            let ratio = shape.ratio(pose, exact, enough, |[xyz, abc, uvw]| {
                let over = |d: f64, limit: f64| if d <= error { 0.0 } else { (d - error) / limit };
                over(xyz, tolerance.linear)
                    .max(over(uvw, tolerance.linear))
                    .max(over(abc, tolerance.angular))
            });
            least = least.min(ratio);
        }
        least
    }
}

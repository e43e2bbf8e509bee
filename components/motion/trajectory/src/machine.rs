//! Limits and settings of a machine, and their check at the door.

use crate::{
    error::Error,
    pose::{AXES, Pose},
};

/// Largest number of joints.
pub const JOINTS: usize = 16;

/// Limits of an axis or joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Highest speed, in units per second.
    pub velocity: f64,
    /// Highest acceleration, in units per second squared.
    pub acceleration: f64,
    /// Highest jerk, in units per second cubed; infinity is no limit.
    pub jerk: f64,
}

impl Limits {
    /// No limit at all.
    pub const NONE: Self =
        Self { velocity: f64::INFINITY, acceleration: f64::INFINITY, jerk: f64::INFINITY };
}

/// Settings of a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// Limits of the axes X Y Z A B C U V W.
    pub axes: [Limits; AXES],
    /// Limits of the joints, as many as the kinematics has.
    pub joints: [Limits; JOINTS],
    /// Servo period in seconds.
    pub period: f64,
    /// Distance from the path in exact mode, in length units.
    pub exact_tolerance: f64,
    /// Distance from the path of rotary axes, in degrees.
    pub angular_tolerance: f64,
    /// Highest feed override, 1 or more. The plan is made for this override.
    pub max_override: f64,
}

impl Machine {
    /// Machine with the same limits on every axis, no limits on joints, a period of 1 ms, an exact tolerance of 0.002,
    /// an angular tolerance of 0.05° and a highest override of 1.
    pub const fn uniform(limits: Limits) -> Self {
        Self {
            axes: [limits; AXES],
            joints: [Limits::NONE; JOINTS],
            period: 1e-3,
            exact_tolerance: 2e-3,
            angular_tolerance: 0.05,
            max_override: 1.0,
        }
    }

    /// Refuses limits and settings that no plan can obey: limits below 1e-6, periods outside 10 µs to 100 ms, tolerances
    /// below 1e-6.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let all = self.axes.iter().enumerate();
        let joints = self.joints.iter().enumerate().map(|(k, l)| (k + 100, l));
        for (index, l) in all.chain(joints) {
            for value in [l.velocity, l.acceleration, l.jerk] {
                if value.is_nan() || value < 1e-6 {
                    return Err(Error::Limit { index, value });
                }
            }
        }
        // Third differences of rounding must stay small against the limits.
        if !(1e-5 <= self.period && self.period <= 0.1) {
            return Err(Error::Setting { value: self.period });
        }
        for value in [self.exact_tolerance, self.angular_tolerance] {
            if !(1e-6 <= value && value.is_finite()) {
                return Err(Error::Setting { value });
            }
        }
        if !(1.0 <= self.max_override && self.max_override <= 100.0) {
            return Err(Error::Setting { value: self.max_override });
        }
        Ok(())
    }

    /// Returns the highest possible speed along any path, in units of its path coordinate per second. Axes without a limit do not
    /// count; no plan is faster than this.
    pub(crate) fn top_speed(&self) -> f64 {
        let all = Pose(self.axes.map(|l| if l.velocity < 1e6 { l.velocity } else { 0.0 }));
        let top = all.dot_all(&all).sqrt();
        if top > 0.0 { top } else { 1e4 }
    }
}

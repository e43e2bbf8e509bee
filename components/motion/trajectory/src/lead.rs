//! The lead-in and the run-out of a motion that follows a spindle, in closed form.

use crate::machine::Limits;
use libm::sqrt;

/// Parts of acceleration and jerk that are certain to be in use while a place is caught.
const USED: [f64; 2] = [0.97, 0.93];

/// Periods by which a place is caught later than in continuous time.
const LATE: f64 = 8.0;

/// Number of halvings in the search for the highest speed of a lead-in.
const HALVINGS: u32 = 40;

impl Limits {
    /// Returns the way that a place of even speed makes until a coordinate that rested at its start moves with it. The
    /// coordinate overtakes the speed, within its velocity, to close the distance. Infinity if it cannot.
    #[must_use]
    pub fn lead_in(&self, speed: f64, period: f64) -> f64 {
        if speed.is_nan() || speed >= self.velocity {
            return f64::INFINITY;
        }
        let ramp = |by: f64| self.ramp(by, USED);
        // Distance to the place after a rise to a speed and the fall to that of the place.
        let behind =
            |top: f64| ramp(top) * (speed - 0.5 * top) - 0.5 * ramp(top - speed) * (top - speed);
        let top = if self.velocity < 1e9 { self.velocity } else { 1e9 };
        let most = if 3.0 * speed < top { 3.0 * speed } else { top };
        let rest = behind(most);
        let time = if rest > 0.0 {
            ramp(most) + ramp(most - speed) + rest / (most - speed)
        } else {
            let (mut low, mut high) = (speed, most);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if behind(middle) > 0.0 { low = middle } else { high = middle }
            }
            ramp(high) + ramp(high - speed)
        };
        speed * (time + LATE * period)
    }

    /// Returns the way in which an even speed comes to rest.
    #[must_use]
    pub fn run_out(&self, speed: f64, period: f64) -> f64 {
        0.5 * speed * self.ramp(speed, USED) + LATE * speed * period
    }

    /// Returns the time of a change of velocity between two even motions.
    fn ramp(&self, by: f64, [acceleration, jerk]: [f64; 2]) -> f64 {
        let (a, j) = (self.acceleration * acceleration, self.jerk * jerk);
        if by <= 0.0 {
            0.0
        } else if by * j > a * a {
            by / a + a / j
        } else {
            2.0 * sqrt(by / j)
        }
    }
}

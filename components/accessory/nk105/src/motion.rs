//! Realtime. Motion along straight lines at constant speeds; the simulated machine has no inertia.

use libm::sqrt;

/// Travel of each axis to either side of machine zero, in millimetres.
pub const TRAVEL: f64 = 500.0;

/// Machine that moves along straight lines.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Place in machine coordinates, in millimetres.
    pub place: [f64; 3],
    target: Option<([f64; 3], f64)>,
}

impl Motion {
    /// Begins a line to a place, limited to the travel, at a speed in mm/s.
    pub fn go(&mut self, to: [f64; 3], speed: f64) {
        self.target = Some((to.map(within), speed));
    }

    /// Stops where it is.
    pub const fn stop(&mut self) {
        self.target = None;
    }

    /// Returns whether a line has not ended.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        self.target.is_some()
    }

    /// Moves with a velocity for each axis for some seconds, at most to the end of the travel. Returns whether it moves.
    pub fn jog(&mut self, velocity: [f64; 3], seconds: f64) -> bool {
        let before = self.place;
        for (place, v) in self.place.iter_mut().zip(velocity) {
            *place = within(*place + v * seconds);
        }
        self.place != before
    }

    /// Follows the line for some seconds, with a factor for its speed; returns the time that is left after its end.
    pub fn follow(&mut self, seconds: f64, factor: f64) -> f64 {
        let Some((to, speed)) = self.target else { return seconds };
        let d = [to[0] - self.place[0], to[1] - self.place[1], to[2] - self.place[2]];
        let way = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        let reach = speed * factor * seconds;
        if way <= reach || way == 0.0 {
            (self.place, self.target) = (to, None);
            return if way == 0.0 { seconds } else { seconds * (1.0 - way / reach) };
        }
        for (place, d) in self.place.iter_mut().zip(d) {
            *place += d * (reach / way);
        }
        0.0
    }
}

/// Returns the place within the travel that is nearest.
const fn within(place: f64) -> f64 {
    f64::max(-TRAVEL, f64::min(TRAVEL, place))
}

//! Realtime. Position that follows another, within limits of speed and acceleration.

/// Position and speed of the follower, and the last target.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Follower {
    at: f64,
    speed: f64,
    last: f64,
}

impl Follower {
    /// Stops at once.
    pub(crate) fn stop(&mut self) {
        self.speed = 0.0;
    }

    /// Advances by one period. Returns the new position.
    ///
    /// The follower moves at full acceleration, in one direction or the other, until it can meet the target's position
    /// and speed within one period. It stops if the maximum speed or acceleration is not above 0, or is NaN. If the
    /// target is not finite, the last target counts.
    pub(crate) fn go(&mut self, wanted: f64, most: f64, accel: f64, dt: f64) -> f64 {
        let wanted = if wanted.is_finite() { wanted } else { self.last };
        if !(most > 0.0 && accel > 0.0) {
            self.stop();
            self.last = wanted;
            return self.at;
        }
        let speed = (wanted - self.last) / dt;
        let step = accel * dt;
        let (mut low, mut high) = (self.speed - step, self.speed + step);
        if low < -most {
            low = -most;
        }
        if high > most {
            high = most;
        }
        let (lowest, highest) = (self.at + low * dt, self.at + high * dt);
        let reaches = lowest <= wanted && wanted <= highest && low <= speed && speed <= high;
        let (at, speed) = if reaches {
            (wanted, (wanted - self.at) / dt)
        } else if self.rises(speed, accel, dt) {
            (highest, high)
        } else {
            (lowest, low)
        };
        (self.at, self.speed) =
            if at.is_finite() && speed.is_finite() { (at, speed) } else { (self.at, 0.0) };
        self.last = wanted;
        self.at
    }

    /// Returns whether the follower must accelerate upward to meet the target.
    fn rises(&self, speed: f64, accel: f64, dt: f64) -> bool {
        let accel = if speed > self.speed { accel } else { -accel };
        let time = (speed - self.speed) / accel;
        let mean = (speed + self.speed + accel * dt) * 0.5;
        let error = self.at + mean * time - (self.last + speed * time);
        let other = -2.0 * accel * dt * time;
        if self.speed == speed && error != 0.0 {
            // At equal speed, both directions take equally long: move toward the target.
            return error < 0.0;
        }
        let turned = error + other * 2.0;
        (accel > 0.0) != (turned.abs() < error.abs())
    }
}

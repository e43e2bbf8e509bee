//! Realtime. Move to a target within limits of speed and acceleration.

/// Position and speed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Planner {
    pub(crate) at: f64,
    pub(crate) speed: f64,
}

impl Planner {
    /// Advances by one period toward a target, or decelerates to rest without one. Returns whether it moves or has not
    /// reached the target.
    ///
    /// The speed is limited so that the axis can still stop at the target. It stops within a deadband of 0.001·a·dt² of
    /// the target.
    pub(crate) fn go(&mut self, target: Option<f64>, most: f64, accel: f64, dt: f64) -> bool {
        let step = accel * dt;
        let tiny = step * dt * 0.001;
        let (mut wanted, mut active) = (0.0, false);
        if let Some(target) = target {
            let far = target - self.at;
            if far > tiny {
                wanted = -step + libm::sqrt(2.0 * accel * far + step * step);
                active = true;
            } else if far < -tiny {
                wanted = step - libm::sqrt(-2.0 * accel * far + step * step);
                active = true;
            }
        }
        if wanted > most {
            wanted = most;
        } else if wanted < -most {
            wanted = -most;
        }
        self.speed = if wanted > self.speed + step {
            self.speed + step
        } else if wanted < self.speed - step {
            self.speed - step
        } else {
            wanted
        };
        self.at += self.speed * dt;
        active || self.speed != 0.0
    }
}

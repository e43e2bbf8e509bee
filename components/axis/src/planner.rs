//! Realtime. A move to a target, with limits of speed and acceleration.

/// Where something is, and how fast.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Planner {
    pub(crate) at: f64,
    pub(crate) speed: f64,
}

impl Planner {
    /// Goes on for a period, to a target, or to rest without one: whether it moves or is on its way.
    ///
    /// The speed is one from which it can still stop at the target; nearer than a thousandth of
    /// what the acceleration does in a period, it is there.
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

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
    /// the target. A speed limit of NaN counts as 0; with an acceleration of NaN, the axis is at rest at once.
    pub(crate) fn go(&mut self, target: Option<f64>, most: f64, accel: f64, dt: f64) -> bool {
        let most = if most.is_nan() { 0.0 } else { most };
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

#[cfg(test)]
mod tests {
    use super::Planner;

    const DT: f64 = 1e-3;

    #[test]
    fn a_speed_limit_of_nan_counts_as_0() {
        let mut axis = Planner::default();
        for _ in 0..100 {
            assert!(axis.go(Some(5.0), f64::NAN, 1000.0, DT), "it has not reached the target");
            assert_eq!((axis.at, axis.speed), (0.0, 0.0));
        }
        // In motion, it slows down and stops.
        for _ in 0..2 {
            axis.go(Some(5.0), 10.0, 1000.0, DT);
        }
        let speeds: Vec<f64> = (0..3)
            .map(|_| {
                axis.go(Some(5.0), f64::NAN, 1000.0, DT);
                axis.speed
            })
            .collect();
        assert_eq!(speeds, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn an_acceleration_of_nan_leaves_the_axis_at_rest() {
        let mut axis = Planner { at: 1.0, speed: 3.0 };
        for target in [Some(5.0), None, Some(-5.0)] {
            axis.go(target, 10.0, f64::NAN, DT);
            assert_eq!((axis.at, axis.speed), (1.0, 0.0));
        }
    }

    #[test]
    fn infinity_is_no_limit() {
        let mut axis = Planner::default();
        axis.go(Some(5.0), f64::INFINITY, 1000.0, DT);
        assert_eq!(axis.speed, 1.0);
        for _ in 0..1000 {
            axis.go(Some(5.0), f64::INFINITY, 1000.0, DT);
        }
        assert!((axis.at - 5.0).abs() < 1e-5 && axis.speed == 0.0, "{axis:?}");
    }
}

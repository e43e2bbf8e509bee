//! The factor by which a blend would have to be longer to carry its speed.

/// Factor by which a blend would have to be longer to carry its speed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// For the limits of acceleration.
    pub(crate) acceleration: f64,
    /// For the limits of jerk; 0 without one.
    pub(crate) jerk: f64,
}

impl Stretch {
    /// Fits everything.
    pub(crate) const NONE: Self = Self { acceleration: 0.0, jerk: 0.0 };

    /// Returns the larger factors of two pieces.
    pub(crate) const fn max(self, other: Self) -> Self {
        Self {
            acceleration: self.acceleration.max(other.acceleration),
            jerk: self.jerk.max(other.jerk),
        }
    }

    /// Returns the factor for both kinds of limits.
    pub(crate) const fn factor(self) -> f64 {
        self.acceleration.max(self.jerk)
    }

    /// Returns the part of its speed that the blend carries, if it is below 1.
    pub(crate) fn carried(self) -> f64 {
        let one = 1.0 / self.acceleration.sqrt();
        one.min(1.0 / libm::cbrt(self.jerk * self.jerk))
    }
}

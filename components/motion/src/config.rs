//! What `motion.configure` sets.

/// A joint's limits and habits, in machine units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointConfig {
    pub(crate) min_limit: f64,
    pub(crate) max_limit: f64,
    pub(crate) max_velocity: f64,
    pub(crate) max_acceleration: f64,
    pub(crate) ferror: f64,
    /// As large as `ferror` when it was never given.
    pub(crate) min_ferror: Option<f64>,
    pub(crate) home: f64,
    pub(crate) home_offset: f64,
    pub(crate) home_search_vel: f64,
    pub(crate) home_latch_vel: f64,
    /// Zero: as fast as the joint may go.
    pub(crate) home_final_vel: f64,
    pub(crate) backlash: f64,
}

impl Default for JointConfig {
    fn default() -> Self {
        Self {
            min_limit: f64::NEG_INFINITY,
            max_limit: f64::INFINITY,
            max_velocity: 1.0,
            max_acceleration: 1.0,
            ferror: 1.0,
            min_ferror: None,
            home: 0.0,
            home_offset: 0.0,
            home_search_vel: 0.0,
            home_latch_vel: 0.0,
            home_final_vel: 0.0,
            backlash: 0.0,
        }
    }
}

impl JointConfig {
    /// The following error allowed at a velocity.
    pub(crate) fn ferror_limit(&self, velocity: f64) -> f64 {
        let least = self.min_ferror.unwrap_or(self.ferror);
        let share = self.ferror * velocity.abs() / self.max_velocity;
        if share > least { share } else { least }
    }
}

/// An axis's limits, in machine units or degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisConfig {
    pub(crate) min_limit: f64,
    pub(crate) max_limit: f64,
    pub(crate) max_velocity: f64,
    pub(crate) max_acceleration: f64,
}

impl Default for AxisConfig {
    fn default() -> Self {
        Self {
            min_limit: f64::NEG_INFINITY,
            max_limit: f64::INFINITY,
            max_velocity: f64::INFINITY,
            max_acceleration: f64::INFINITY,
        }
    }
}

/// The limits of coordinated moves, in machine units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrajConfig {
    pub(crate) max_velocity: f64,
    pub(crate) max_acceleration: f64,
    pub(crate) default_velocity: f64,
    /// How many machine units a millimetre is.
    pub(crate) units_per_mm: f64,
    /// The highest factor that adaptive feed and override may have.
    pub(crate) max_feed_override: f64,
}

impl Default for TrajConfig {
    fn default() -> Self {
        Self {
            max_velocity: f64::INFINITY,
            max_acceleration: f64::INFINITY,
            default_velocity: 1.0,
            units_per_mm: 1.0,
            max_feed_override: 1.0,
        }
    }
}

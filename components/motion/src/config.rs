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
    pub(crate) home: HomeConfig,
    pub(crate) backlash: f64,
}

/// How a joint is homed, in machine units and seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HomeConfig {
    /// Where it goes in the end.
    pub(crate) place: f64,
    /// What the switch, the index or the place where it stands is called.
    pub(crate) offset: f64,
    /// Towards the switch; zero: there is none.
    pub(crate) search_vel: f64,
    /// Onto or off the switch's edge; zero: it is home where it stands.
    pub(crate) latch_vel: f64,
    /// Zero: as fast as the joint may go.
    pub(crate) final_vel: f64,
    /// Joints are homed in this order; those below zero make their final move together.
    pub(crate) sequence: i32,
    pub(crate) encoder: Encoder,
    pub(crate) use_index: bool,
    pub(crate) ignore_limits: bool,
    /// Several joints have this switch together.
    pub(crate) is_shared: bool,
    /// No longer homed when the machine goes off.
    pub(crate) is_volatile: bool,
}

/// What the encoder tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Encoder {
    /// The way; its index sets it to zero.
    #[default]
    Resets,
    /// The way; its index does not.
    Goes,
    /// The place.
    Absolute,
    /// The place, and homing does not move.
    AbsoluteStill,
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
            home: HomeConfig::default(),
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
    /// What an external offset has of velocity and acceleration; 0: there is no offset.
    pub(crate) offset_share: f64,
}

impl Default for AxisConfig {
    fn default() -> Self {
        Self {
            min_limit: f64::NEG_INFINITY,
            max_limit: f64::INFINITY,
            max_velocity: f64::INFINITY,
            max_acceleration: f64::INFINITY,
            offset_share: 0.0,
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

impl Encoder {
    /// Its position is zero at the index.
    pub(crate) fn resets(self) -> bool {
        self == Self::Resets
    }
}

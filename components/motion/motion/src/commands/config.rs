//! Settings of `motion.configure`.

use hal_safety::Reaction;

/// Fraction of a joint's velocity and acceleration for its correction, if none is set.
pub(crate) const DEFAULT_SHARE: f64 = 0.1;

/// Limits and homing settings of a joint, in machine units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointConfig {
    pub(crate) min_limit: f64,
    pub(crate) max_limit: f64,
    pub(crate) max_velocity: f64,
    pub(crate) max_acceleration: f64,
    /// Infinite if there is no limit.
    pub(crate) max_jerk: f64,
    pub(crate) ferror: f64,
    /// Minimum following error; `ferror` if it was never set.
    pub(crate) min_ferror: Option<f64>,
    pub(crate) home: HomeConfig,
    pub(crate) backlash: f64,
    /// Place in [`Tables`](crate::compensation::Tables) of the screw's measured errors, which replace the backlash.
    pub(crate) table: Option<usize>,
    /// Fraction of velocity and acceleration that is reserved for the correction, if it was set.
    pub(crate) correction_share: Option<f64>,
    /// Reaction to a closed limit switch and to a following error.
    pub(crate) fault_stop: Reaction,
}

/// Homing settings of a joint, in machine units and seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HomeConfig {
    /// Position of the final move.
    pub(crate) place: f64,
    /// Position assigned to the switch, the index, or the current place.
    pub(crate) offset: f64,
    /// Velocity towards the switch; zero if there is none.
    pub(crate) search_vel: f64,
    /// Velocity onto or off the switch's edge; zero if the joint is homed in place.
    pub(crate) latch_vel: f64,
    /// Velocity of the final move; zero for the joint's velocity limit.
    pub(crate) final_vel: f64,
    /// Order in which joints are homed; joints with negative numbers make their final move together.
    pub(crate) sequence: i32,
    pub(crate) encoder: Encoder,
    pub(crate) use_index: bool,
    pub(crate) ignore_limits: bool,
    /// True if several joints share this switch.
    pub(crate) is_shared: bool,
    /// True if the joint loses its homed state when the machine goes off.
    pub(crate) is_volatile: bool,
    /// True if the joint is an indexer whose lock opens before each move and closes after it.
    pub(crate) is_locking: bool,
}

/// Kind of encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Encoder {
    /// Incremental; its index resets it to zero.
    #[default]
    Resets,
    /// Incremental; its index does not reset it.
    Goes,
    /// Absolute.
    Absolute,
    /// Absolute, and homing does not move the joint.
    AbsoluteStill,
}

impl Default for JointConfig {
    fn default() -> Self {
        Self {
            min_limit: f64::NEG_INFINITY,
            max_limit: f64::INFINITY,
            max_velocity: 1.0,
            max_acceleration: 1.0,
            max_jerk: f64::INFINITY,
            ferror: 1.0,
            min_ferror: None,
            home: HomeConfig::default(),
            backlash: 0.0,
            table: None,
            correction_share: None,
            fault_stop: Reaction::Drop,
        }
    }
}

impl JointConfig {
    /// Returns the fraction of velocity and acceleration that is reserved for the correction.
    pub(crate) fn correction_share(&self) -> f64 {
        if self.backlash == 0.0 && self.table.is_none() {
            return 0.0;
        }
        self.correction_share.unwrap_or(DEFAULT_SHARE)
    }

    /// Returns the velocity that the correction leaves to moves.
    pub(crate) fn move_velocity(&self) -> f64 {
        self.max_velocity * (1.0 - self.correction_share())
    }

    /// Returns the acceleration that the correction leaves to moves.
    pub(crate) fn move_acceleration(&self) -> f64 {
        self.max_acceleration * (1.0 - self.correction_share())
    }

    /// Returns the jerk that the correction leaves to moves.
    pub(crate) fn move_jerk(&self) -> f64 {
        self.max_jerk * (1.0 - self.correction_share())
    }

    /// Returns the following error allowed at a velocity.
    pub(crate) fn ferror_limit(&self, velocity: f64) -> f64 {
        let least = self.min_ferror.unwrap_or(self.ferror);
        let fraction = self.ferror * velocity.abs() / self.max_velocity;
        if fraction > least { fraction } else { least }
    }
}

/// Limits of an axis, in machine units or degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisConfig {
    pub(crate) min_limit: f64,
    pub(crate) max_limit: f64,
    pub(crate) max_velocity: f64,
    pub(crate) max_acceleration: f64,
    /// Infinite if there is no limit.
    pub(crate) max_jerk: f64,
    /// External offset's fraction of velocity and acceleration; 0 if there is no offset.
    pub(crate) offset_fraction: f64,
}

impl Default for AxisConfig {
    fn default() -> Self {
        Self {
            min_limit: f64::NEG_INFINITY,
            max_limit: f64::INFINITY,
            max_velocity: f64::INFINITY,
            max_acceleration: f64::INFINITY,
            max_jerk: f64::INFINITY,
            offset_fraction: 0.0,
        }
    }
}

/// Limits of coordinated moves, in machine units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrajConfig {
    pub(crate) max_velocity: f64,
    pub(crate) max_acceleration: f64,
    /// Jerk along a path in x y z or u v w; infinite if there is no limit.
    pub(crate) max_jerk: f64,
    pub(crate) default_velocity: f64,
    /// Number of machine units per millimetre.
    pub(crate) units_per_mm: f64,
    /// Maximum of adaptive feed and of the override.
    pub(crate) max_feed_override: f64,
}

impl Default for TrajConfig {
    fn default() -> Self {
        Self {
            max_velocity: f64::INFINITY,
            max_acceleration: f64::INFINITY,
            max_jerk: f64::INFINITY,
            default_velocity: 1.0,
            units_per_mm: 1.0,
            max_feed_override: 1.0,
        }
    }
}

/// Speed limits of a spindle, in turns per minute, without sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpindleConfig {
    pub(crate) min_forward: f64,
    pub(crate) max_forward: f64,
    /// Limits in reverse; those of forward if they were never set.
    pub(crate) min_reverse: Option<f64>,
    pub(crate) max_reverse: Option<f64>,
    /// Distance from their place at the spindle at which axes that follow it stop.
    pub(crate) sync_error: f64,
}

impl Default for SpindleConfig {
    fn default() -> Self {
        Self {
            min_forward: 0.0,
            max_forward: f64::INFINITY,
            min_reverse: None,
            max_reverse: None,
            sync_error: f64::INFINITY,
        }
    }
}

impl SpindleConfig {
    /// Returns the limits of a direction: lowest and highest speed.
    pub(crate) fn limits(&self, forward: bool) -> (f64, f64) {
        if forward {
            return (self.min_forward, self.max_forward);
        }
        (self.min_reverse.unwrap_or(self.min_forward), self.max_reverse.unwrap_or(self.max_forward))
    }

    /// Returns the speed within the limits of its direction; zero stays zero.
    pub(crate) fn limited(&self, speed: f64) -> f64 {
        if speed == 0.0 {
            return speed;
        }
        let (min, max) = self.limits(speed > 0.0);
        let size = libm::fabs(speed);
        let size = if size < min { min } else { size };
        libm::copysign(if size > max { max } else { size }, speed)
    }
}

impl TrajConfig {
    /// Returns whether a path planned for the limits `old` may break these.
    pub(crate) fn is_tighter(&self, old: &Self) -> bool {
        self.max_acceleration < old.max_acceleration || self.max_jerk < old.max_jerk
    }

    /// Returns the highest override for which moves are planned.
    pub(crate) fn planned_override(&self) -> f64 {
        let most = self.max_feed_override;
        if most < 1.0 {
            1.0
        } else if most < 100.0 {
            most
        } else {
            100.0
        }
    }
}

impl JointConfig {
    /// Returns whether a path planned for the limits `old` may break these.
    pub(crate) fn is_tighter(&self, old: &Self) -> bool {
        self.max_velocity < old.max_velocity
            || self.max_acceleration < old.max_acceleration
            || self.max_jerk < old.max_jerk
            || self.max_limit < old.max_limit
            || self.min_limit > old.min_limit
            || self.correction_share() > old.correction_share()
    }
}

impl AxisConfig {
    /// Returns whether a path planned for the limits `old` may break these.
    pub(crate) fn is_tighter(&self, old: &Self) -> bool {
        self.max_velocity < old.max_velocity
            || self.max_acceleration < old.max_acceleration
            || self.max_jerk < old.max_jerk
            || self.max_limit < old.max_limit
            || self.min_limit > old.min_limit
            || self.offset_fraction > old.offset_fraction
    }
}

impl Encoder {
    /// Returns whether the index resets the encoder's position to zero.
    pub(crate) fn resets(self) -> bool {
        self == Self::Resets
    }
}

/// Returns a limit of jerk as commands give it: 0 is no limit.
const fn written(jerk: f64) -> f64 {
    if jerk.is_finite() { jerk } else { 0.0 }
}

impl JointConfig {
    /// Returns a setting by the name of its argument.
    pub(crate) fn setting(&self, name: &str) -> Option<f64> {
        Some(match name {
            "min-limit" => self.min_limit,
            "max-limit" => self.max_limit,
            "max-velocity" => self.max_velocity,
            "max-acceleration" => self.max_acceleration,
            "max-jerk" => written(self.max_jerk),
            "ferror" => self.ferror,
            "min-ferror" => self.min_ferror.unwrap_or(self.ferror),
            "home" => self.home.place,
            "home-offset" => self.home.offset,
            "home-sequence" => f64::from(self.home.sequence),
            "backlash" => self.backlash,
            _ => return None,
        })
    }
}

impl AxisConfig {
    /// Returns a setting by the name of its argument.
    pub(crate) fn setting(&self, name: &str) -> Option<f64> {
        Some(match name {
            "min-limit" => self.min_limit,
            "max-limit" => self.max_limit,
            "max-velocity" => self.max_velocity,
            "max-acceleration" => self.max_acceleration,
            "max-jerk" => written(self.max_jerk),
            "offset-av-ratio" => self.offset_fraction,
            _ => return None,
        })
    }
}

impl TrajConfig {
    /// Returns a setting by the name of its argument.
    pub(crate) fn setting(&self, name: &str) -> Option<f64> {
        Some(match name {
            "max-velocity" => self.max_velocity,
            "max-acceleration" => self.max_acceleration,
            "max-jerk" => written(self.max_jerk),
            "default-velocity" => self.default_velocity,
            "max-feed-override" => self.max_feed_override,
            _ => return None,
        })
    }
}

impl SpindleConfig {
    /// Returns a setting by the name of its argument.
    pub(crate) fn setting(&self, name: &str) -> Option<f64> {
        Some(match name {
            "min-forward-velocity" => self.limits(true).0,
            "max-forward-velocity" => self.limits(true).1,
            "min-reverse-velocity" => self.limits(false).0,
            "max-reverse-velocity" => self.limits(false).1,
            _ => return None,
        })
    }
}

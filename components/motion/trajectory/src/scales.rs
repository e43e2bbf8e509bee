//! Realtime. The overrides of a period.

/// Highest feed override that counts.
const MAX_FEED: f64 = 1e6;

/// Overrides of a period, as factors. A number is both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Override of moves at a feed; 0 holds them.
    pub feed: f64,
    /// Override of rapid moves, up to 1; 0 holds them.
    pub rapid: f64,
}

impl Scales {
    /// Programmed speeds.
    pub const FULL: Self = Self { feed: 1.0, rapid: 1.0 };
    /// A hold of all motion.
    pub const HOLD: Self = Self { feed: 0.0, rapid: 0.0 };

    /// Returns factors that can be used: NaN and negative ones hold.
    pub(crate) const fn usable(self) -> Self {
        const fn within(scale: f64, most: f64) -> f64 {
            if scale > 0.0 { scale.min(most) } else { 0.0 }
        }
        Self { feed: within(self.feed, MAX_FEED), rapid: within(self.rapid, 1.0) }
    }
}

impl From<f64> for Scales {
    fn from(scale: f64) -> Self {
        Self { feed: scale, rapid: scale }
    }
}

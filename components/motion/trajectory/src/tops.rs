//! Realtime. The highest speeds of a period, whatever was planned.

/// Highest speeds in a period, of the group of axes that governs the feed: of XYZ, else of UVW, else of ABC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tops {
    /// Of XYZ or UVW, in length units per second. Angles alone have no such limit.
    pub linear: f64,
    /// Of any group, in its units per second, as that of a feed per turn.
    pub feed: f64,
}

impl Tops {
    /// No limit.
    pub const NONE: Self = Self { linear: f64::INFINITY, feed: f64::INFINITY };

    /// Returns speeds that can be used: with NaN and negative ones nothing moves.
    pub(crate) const fn usable(self) -> Self {
        const fn from_zero(speed: f64) -> f64 {
            if speed > 0.0 { speed } else { 0.0 }
        }
        Self { linear: from_zero(self.linear), feed: from_zero(self.feed) }
    }
}

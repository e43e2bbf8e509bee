//! The G codes in force.

use super::{FeedMode, Side, State};
use crate::canon::{PathMode, Plane, Unit};

/// Number of G codes in force.
pub const G_CODES: usize = 13;

impl State {
    /// Returns the G codes in force, times ten: motion, plane, unit, compensation, tool offset, coordinate system, path
    /// control, diameter, distance, distance of arcs, feed, spindle, retract.
    pub fn g_codes(&self) -> [u32; G_CODES] {
        let modal = &self.modal;
        let system = u32::from(modal.system);
        let css = modal.spindles.first().is_some_and(|s| s.css);
        [
            modal.motion.into(),
            match modal.plane {
                Plane::Xy => 170,
                Plane::Xz => 180,
                Plane::Yz => 190,
                Plane::Uv => 171,
                Plane::Uw => 181,
                Plane::Vw => 191,
            },
            if modal.unit == Unit::Inch { 200 } else { 210 },
            match self.compensation.side() {
                Side::Off => 400,
                Side::Left => 410,
                Side::Right => 420,
            },
            if modal.tool_offset { 430 } else { 490 },
            if system <= 6 { 530 + 10 * system } else { 590 + system - 6 },
            match modal.path {
                PathMode::ExactPath => 610,
                PathMode::ExactStop => 611,
                PathMode::Continuous { .. } => 640,
            },
            if modal.diameter { 70 } else { 80 },
            if modal.absolute { 900 } else { 910 },
            if modal.ijk_absolute { 901 } else { 911 },
            match modal.feed_mode {
                FeedMode::InverseTime => 930,
                FeedMode::PerMinute => 940,
                FeedMode::PerRevolution => 950,
            },
            if css { 960 } else { 970 },
            if modal.retract_old { 980 } else { 990 },
        ]
    }
}

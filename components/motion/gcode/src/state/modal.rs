//! Modal state: what stays in force from line to line.

use serde::{Deserialize, Serialize};

use crate::canon::{Direction, PathMode, Plane, Unit};

/// The meaning of F.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FeedMode {
    /// G93
    InverseTime,
    /// G94
    PerMinute,
    /// G95
    PerRevolution,
}

/// The side of cutter compensation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// G40
    Off,
    /// G41
    Left,
    /// G42
    Right,
}

/// A spindle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spindle {
    /// S, in revolutions per minute, or the surface speed.
    pub speed: f64,
    /// The direction.
    pub direction: Direction,
    /// Constant surface speed (G96).
    pub css: bool,
    /// Top speed of constant surface speed in turns per minute (D of G96).
    pub css_max: f64,
    /// The speed override is enabled.
    pub speed_override: bool,
}

/// The most spindles.
pub const MAX_SPINDLES: usize = 8;

/// Everything modal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Modal {
    /// Ten times the G code of motion; 800 for none.
    pub motion: u16,
    /// The plane.
    pub plane: Plane,
    /// G90
    pub absolute: bool,
    /// G90.1
    pub ijk_absolute: bool,
    /// The meaning of F.
    pub feed_mode: FeedMode,
    /// The spindle of G95.
    pub feed_spindle: u8,
    /// F.
    pub feed: f64,
    /// The unit.
    pub unit: Unit,
    /// G98: cycles retract to the old level.
    pub retract_old: bool,
    /// The coordinate system, 1 for G54.
    pub system: u8,
    /// The path control mode.
    pub path: PathMode,
    /// The tolerance of G64 Q.
    pub naive_tolerance: f64,
    /// G7
    pub diameter: bool,
    /// G43 and its kin are in force.
    pub tool_offset: bool,
    /// The spindles.
    pub spindles: Vec<Spindle>,
    /// M7
    pub mist: bool,
    /// M8
    pub flood: bool,
    /// The feed override is enabled.
    pub feed_override: bool,
    /// Adaptive feed is enabled.
    pub adaptive_feed: bool,
    /// Feed hold is enabled.
    pub feed_hold: bool,
}

impl Modal {
    /// Returns the state at power-on.
    pub fn new(unit: Unit, spindles: u8) -> Self {
        let spindle = Spindle {
            speed: 0.0,
            direction: Direction::Stopped,
            css: false,
            css_max: 0.0,
            speed_override: true,
        };
        Self {
            motion: 800,
            plane: Plane::Xy,
            absolute: true,
            ijk_absolute: false,
            feed_mode: FeedMode::PerMinute,
            feed_spindle: 0,
            feed: 0.0,
            unit,
            retract_old: false,
            system: 1,
            path: PathMode::Continuous { tolerance: 0.0 },
            naive_tolerance: 0.0,
            diameter: false,
            tool_offset: false,
            spindles: vec![spindle; usize::from(spindles).min(MAX_SPINDLES)],
            mist: false,
            flood: false,
            feed_override: true,
            adaptive_feed: false,
            feed_hold: true,
        }
    }
}

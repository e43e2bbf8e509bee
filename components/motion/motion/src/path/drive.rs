//! Realtime. Inputs of a path in each cycle.

use hal_trajectory::{Pursuit, Scales, Tops};

/// Inputs of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive {
    pub(crate) dt: f64,
    /// Overrides of feeds and of rapid moves; 0 holds.
    pub(crate) scales: Scales,
    /// Overrides of a retract during a hold; 0 where the retract holds too.
    pub(crate) retract: Scales,
    /// Highest speeds of a retract.
    pub(crate) retract_tops: Tops,
    /// True to run backwards.
    pub(crate) reverse: bool,
    /// Highest speeds along the path.
    pub(crate) tops: Tops,
    /// False while a motion that rests may not begin.
    pub(crate) may_begin: bool,
    /// State of the probe.
    pub(crate) probe: bool,
    /// Motion of a path that follows a spindle.
    pub(crate) pace: Option<Pace>,
}

/// Motion for one cycle of a move that follows a spindle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Place along the path.
    pub(crate) goal: Pursuit,
    /// True if the axes wait for the spindle.
    pub(crate) waits: bool,
}

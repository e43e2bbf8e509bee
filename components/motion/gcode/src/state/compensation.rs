//! Cutter radius compensation on its way: the side, the tool, and the calls whose ends may still change.

use serde::{Deserialize, Serialize};

use super::Side;
use crate::{canon::Issued, motion::geometry::Point};

/// The compensated path of the last move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Path {
    /// A line from this point in this direction.
    Line {
        /// The start point.
        from: Point,
        /// The unit direction.
        direction: Point,
    },
    /// An arc.
    Arc {
        /// The start point.
        from: Point,
        /// The centre.
        centre: Point,
        /// The radius.
        radius: f64,
        /// The number of turns, negative for clockwise.
        turns: i32,
    },
}

/// The last move, whose end the next one may change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LastMove {
    /// The compensated path.
    pub path: Path,
    /// The programmed direction at its end.
    pub direction: Point,
}

/// The state of cutter radius compensation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Compensation {
    /// Twice the side: the sign is that of the left normal.
    pub(crate) side: i8,
    /// The radius of the tool.
    pub radius: f64,
    /// The orientation of a lathe tool.
    pub orientation: u8,
    /// The programmed position; `None` before the first move.
    pub program: Option<Point>,
    /// The last move, if its end may still change.
    pub last: Option<LastMove>,
    /// The last move was handed out, so that its end cannot change.
    #[serde(default)]
    pub fixed: bool,
    /// Compensation has ended, and no straight move has come since: the tool is beside the place of the program.
    #[serde(default)]
    pub ended: bool,
    /// The calls from the last move on.
    pub queue: Vec<Issued>,
}

impl Compensation {
    /// Returns the side and the tool, without a path.
    pub(crate) fn setting(&self) -> Self {
        Self {
            side: self.side,
            radius: self.radius,
            orientation: self.orientation,
            ended: self.ended,
            ..Self::default()
        }
    }

    /// Tells whether compensation is on.
    pub fn is_on(&self) -> bool {
        self.side != 0
    }

    /// Tells whether compensation moves the path: a tool without a radius is on the programmed lines.
    pub(crate) fn moves_path(&self) -> bool {
        self.is_on() && self.radius > 0.0
    }

    /// Returns the side.
    pub fn side(&self) -> Side {
        match self.side {
            0 => Side::Off,
            1.. => Side::Left,
            _ => Side::Right,
        }
    }

    /// Returns 1 for the left side and -1 for the right one.
    pub(crate) fn sign(&self) -> f64 {
        f64::from(self.side)
    }

    /// Tells whether calls wait for the end of a move.
    pub(crate) fn holds(&self) -> bool {
        self.last.is_some() && !self.fixed
    }

    /// Forgets the path after motion from elsewhere.
    pub(crate) fn forget(&mut self) {
        self.program = None;
        self.last = None;
        self.fixed = false;
        self.ended = false;
        self.queue.clear();
    }
}

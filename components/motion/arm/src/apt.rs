//! Cutter-location files in the text form of ISO 4343 (APT), as CAM systems write them: positions and tool axes.

mod arc;
mod items;
mod problem;
mod read;
mod scan;

pub use problem::{Error, Problem};

use crate::rotation::Vector;

/// Largest size of a file, in bytes.
pub const MAX_BYTES: usize = 64 << 20;
/// Largest number of points of a part, those on arcs included.
pub const MAX_POINTS: usize = 200_000;

/// Points of a part in their order, in millimetres.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Part {
    /// Text of `PARTNO`.
    pub name: String,
    /// Points.
    pub points: Vec<Point>,
    /// Statements that concern the machine and not the path.
    pub events: Vec<Event>,
    /// Words without effect, with line numbers.
    pub warnings: Vec<(u32, String)>,
}

/// Point of the path, reached in a straight line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Point {
    /// Line of the statement, from 1.
    pub line: u32,
    /// Tip of the tool, in millimetres.
    pub place: Vector,
    /// Unit vector from the tip to the holder.
    pub axis: Vector,
    /// Motion that leads to the point.
    pub motion: Motion,
}

/// Motion that leads to a point.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Motion {
    /// None: the path begins here.
    Start,
    /// As fast as the machine can.
    Rapid,
    /// At this feed in millimetres per second; `None` before any feed is given.
    Feed(Option<f64>),
}

/// Statement that concerns the machine.
#[derive(Clone, PartialEq, Debug)]
pub struct Event {
    /// Line of the statement, from 1.
    pub line: u32,
    /// Number of points before it.
    pub after: usize,
    /// Statement, in capitals without blanks.
    pub text: String,
}

impl Part {
    /// Reads a file.
    ///
    /// # Errors
    /// The first statement that is wrong or not supported, or the file is too large or ends before its end.
    pub fn parse(text: &[u8]) -> Result<Self, Error> {
        read::read(text)
    }

    /// Returns the mean of the points; `None` if there are none.
    #[must_use]
    pub fn centre(&self) -> Option<Vector> {
        let sum: Vector = self.points.iter().map(|p| p.place).sum();
        (!self.points.is_empty()).then(|| sum / self.points.len() as f64)
    }
}

//! Realtime. Digital lines of a chip, up to 64 in one call.

use crate::Lost;
use std::sync::Arc;

/// Realtime. Lines of one chip that were requested together, each by its bit.
///
/// A level is TRUE for an active line: a back end inverts lines that are active low.
pub trait Lines: Send + Sync {
    /// Returns the levels of the lines of `mask`, at one moment.
    ///
    /// # Errors
    /// The chip does not answer.
    fn read(&self, mask: u64) -> Result<u64, Lost>;

    /// Drives the output lines of `mask` to `levels`, at one moment.
    ///
    /// # Errors
    /// The chip does not answer.
    fn write(&self, levels: u64, mask: u64) -> Result<(), Lost>;

    /// Takes waiting edges, the oldest first, into `room`, at most 64 at once. Returns their number, which is less than
    /// the room and 64 when no edge waits any more. Never waits.
    ///
    /// # Errors
    /// The chip does not answer.
    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost>;
}

impl<L: Lines + ?Sized> Lines for Arc<L> {
    fn read(&self, mask: u64) -> Result<u64, Lost> {
        (**self).read(mask)
    }

    fn write(&self, levels: u64, mask: u64) -> Result<(), Lost> {
        (**self).write(levels, mask)
    }

    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost> {
        (**self).edges(room)
    }
}

/// Edge of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineEdge {
    /// Time at which the kernel saw the edge, in nanoseconds.
    pub at_ns: u64,
    /// Number of the edge among those of all lines requested together; edges that a full queue lost leave a gap.
    pub number: u32,
    /// Bit of the line.
    pub bit: u8,
    /// True if the line became active.
    pub is_rising: bool,
}

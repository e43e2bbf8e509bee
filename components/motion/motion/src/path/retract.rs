//! Realtime. A hold in a thread: the tool leaves the workpiece before the axes rest.
//!
//! A hold cannot stop a thread, and the end of the thread is no place to rest, because the tool would rub there while the
//! spindle turns. The move that follows the thread in the program therefore goes on, and the hold takes effect as it ends.

use super::{
    Drive, Path,
    order::{Item, Kind},
    spindle::Course,
};

/// Exception from a hold, for the move behind a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Retract {
    No,
    /// A hold waits for the end of a thread.
    Due,
    /// The move with this number goes on.
    Of(u32),
}

impl Path {
    /// Returns whether the path goes on in spite of a hold. Notes holds in threads.
    pub(super) fn retracts(&mut self, drive: &Drive) -> bool {
        let is_held = self.paused || drive.scale == 0.0;
        let is_threading = matches!(self.course, Course::Thread(_)) && drive.pace.is_some();
        self.retract = match self.retract {
            // A move that is not in the queue as the thread ends is no retract.
            _ if !is_held || self.is_idle() => Retract::No,
            _ if is_threading && self.is_bound() => Retract::Due,
            Retract::Of(id) if self.last.line != 0 && self.last.line != id => Retract::No,
            other => other,
        };
        matches!(self.retract, Retract::Of(_))
    }

    /// Permits the first move of a path that begins behind a thread.
    pub(super) fn permit_retract(&mut self) {
        let first = self.pending.iter().find_map(|p| match p.item {
            Item::Move(order) => Some((p.id, order.kind)),
            Item::Output(_) => None,
        });
        self.retract = match (self.retract, first) {
            (Retract::Due | Retract::Of(_), Some((id, kind)))
                if self.course == Course::Free && kind != Kind::Probe =>
            {
                Retract::Of(id)
            }
            _ => Retract::No,
        };
    }
}

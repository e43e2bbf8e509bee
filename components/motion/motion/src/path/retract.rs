//! Realtime. A hold in a thread: the tool leaves the workpiece before the axes rest.
//!
//! A hold cannot stop a thread, and the end of the thread is no place to rest, because the tool would rub there while the
//! spindle turns. The move that follows the thread in the program therefore goes on to its end, and the axes rest there.
//! A retract that something else stops is dropped: the hold then takes effect, and only its end moves the axes again.

use super::{
    Drive, Path,
    order::{Item, Kind, PathMove},
    spindle::Course,
};
use hal_trajectory::Scales;

/// Exception from a hold, for the move behind a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Retract {
    No,
    /// A hold waits for the end of a thread.
    Due,
    /// The move with this number goes on, on a path of its own.
    Of(u32),
}

impl Path {
    /// Returns whether the path goes on in spite of a hold. Notes holds in threads.
    pub(super) fn retracts(&mut self, drive: &Drive) -> bool {
        let Scales { feed, rapid } = drive.scales;
        let is_held = self.paused || feed == 0.0 || rapid == 0.0;
        let is_threading = matches!(self.course, Course::Thread(_)) && drive.pace.is_some();
        self.retract = match self.retract {
            // A move that is not in the queue as the thread ends is no retract.
            _ if !is_held || self.is_idle() => Retract::No,
            _ if is_threading && self.is_bound() => Retract::Due,
            Retract::Of(id) if !self.goes_back_out(id, drive) => Retract::No,
            other => other,
        };
        matches!(self.retract, Retract::Of(_))
    }

    /// Returns whether the retract with this number is not over, and nothing but the hold stops it.
    fn goes_back_out(&self, id: u32, drive: &Drive) -> bool {
        let next = self.next_move().filter(|(next, _)| *next == id);
        let Some((_, order)) = next else { return false };
        // Before its first cycle, the path has no line.
        let rests = !self.last.moving && (self.last.line != 0 || !drive.may_begin);
        let stands = order.kind.scale(&drive.retract) == 0.0 || drive.retract_tops.feed == 0.0;
        !rests && !stands && self.stop.is_none() && self.reverse == drive.reverse
    }

    /// Permits the first move of a path that begins behind a thread.
    pub(super) fn permit_retract(&mut self) {
        let first = self.next_move().map(|(id, order)| (id, order.kind));
        self.retract = match (self.retract, first) {
            (Retract::Due, Some((id, kind)))
                if self.course == Course::Free && kind != Kind::Probe =>
            {
                Retract::Of(id)
            }
            _ => Retract::No,
        };
    }

    /// Returns the first move that has not ended, and its number.
    pub(super) fn next_move(&self) -> Option<(u32, &PathMove)> {
        self.pending.iter().find_map(|p| match &p.item {
            Item::Move(order) => Some((p.id, order)),
            Item::Output(_) => None,
        })
    }
}

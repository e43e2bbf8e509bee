//! Realtime. Feeds depend on the spindles that were turned for them: none runs while somebody else has stopped such a
//! spindle, until a resume turns it again.

use super::{
    Parked, Path,
    order::{Item, Kind},
};
use crate::{commands::refusal::Refusal, state::State};
use hal_component::MotionSource;
use hal_safety::Event;
use hal_trajectory::Scales;

impl Path {
    /// Returns whether a move other than a rapid one is in progress, or is the next one of a path at rest. A rapid move that has
    /// come to rest before its end, in the corner to such a move, counts as that.
    fn is_feed_due(&self) -> bool {
        let is_feed = |kind: Kind| kind != Kind::Rapid;
        if self.last.moving {
            return self.known(self.last.line).is_some_and(|known| is_feed(known.kind));
        }
        let mut moves = self.pending.iter().filter_map(|pending| match &pending.item {
            Item::Move(order) => Some((pending.id, order.kind)),
            Item::Output(_) => None,
        });
        let Some((id, kind)) = moves.next() else { return false };
        let has_begun = id == self.last.line && self.travelled > 0.0;
        is_feed(kind) || has_begun && moves.next().is_some_and(|(_, kind)| is_feed(kind))
    }
}

impl State {
    /// Returns the overrides of this cycle: feeds hold while a spindle of theirs is stopped. A feed in progress, and the next
    /// one, pauses the path, which only a resume ends.
    pub(super) fn held_scales(&mut self) -> (Scales, Scales) {
        let (net, retract) = (self.feed.net, self.feed.retract);
        if !self.has_lost_spindle(self.path_source()) {
            return (net, retract);
        }
        if !self.path.is_paused() && self.path.is_feed_due() {
            self.tell(Event::SpindleStopped, "");
        }
        (Scales { feed: 0.0, ..net }, Scales { feed: 0.0, ..retract })
    }

    fn has_lost_spindle(&self, source: MotionSource) -> bool {
        self.spindles.iter().any(|spindle| spindle.is_lost(source))
    }

    /// Returns the spindles that were stopped after they had been turned for the path in progress, or for a program.
    pub(crate) fn lost_spindles(&self) -> u32 {
        let source = self.spindle_source(MotionSource::Task);
        let bits = self.spindles.iter().map(|spindle| spindle.is_lost(source));
        bits.enumerate().fold(0, |sum, (n, lost)| sum | u32::from(lost) << n)
    }

    /// Returns the source whose spindles matter: that of the path, and without a path this one.
    fn spindle_source(&self, without: MotionSource) -> MotionSource {
        let is_idle = self.path.is_idle() && self.path.parked() == Parked::No;
        if is_idle { without } else { self.path_source() }
    }

    /// Turns the spindles again that the path in progress needs, and without a path those that this source needs.
    pub(crate) fn restart_spindles(&mut self, source: MotionSource) -> Result<(), Refusal> {
        let source = self.spindle_source(source);
        // Either all of them turn, or none.
        for (n, spindle) in self.spindles.iter().enumerate() {
            spindle.may_restart(source, n)?;
        }
        for spindle in &mut self.spindles {
            if spindle.restart(source) {
                // Its pin at-speed of this cycle is that of a spindle at rest.
                (spindle.at_speed, self.at_speed) = (false, false);
            }
        }
        Ok(())
    }
}

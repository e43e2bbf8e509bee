//! Realtime. Origins of motion: two of them never move at once.

use crate::{path::Parked, state::State};
use hal_component::MotionSource;
use hal_safety::{Event, OrderSource, Refused};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Reason for which remote motion ends.
pub(crate) const REMOTE_ENDED: &str = "a local source ended remote motion";

/// The claim of the service's owner.
#[derive(Debug, Default)]
pub(crate) struct Origin {
    /// True while the owner of the service keeps other sources from beginning motion.
    pub(crate) claimed: Arc<AtomicBool>,
}

impl Origin {
    pub(crate) fn is_claimed(&self) -> bool {
        self.claimed.load(Ordering::Relaxed) // Commands that follow a claim come through a queue.
    }

    /// Ends the claim.
    pub(crate) fn free(&self) {
        self.claimed.store(false, Ordering::Relaxed);
    }
}

impl State {
    /// A wheel has turned: it begins local motion, or ends remote motion. Returns whether it may move something.
    pub(crate) fn take_wheel(&mut self) -> bool {
        let answer = self.tell(Event::Wheel, REMOTE_ENDED);
        if answer.refused == Some(Refused::Ended) {
            self.say.warn(REMOTE_ENDED, &[]);
        }
        answer.refused.is_none()
    }

    /// Returns the origin of what moves, or of what moved last.
    pub(crate) fn origin_in_progress(&self) -> MotionSource {
        let rests = self.path.can_park() || self.path.parked() != Parked::No;
        from(self.machine.source(rests && self.is_jogging()))
    }

    /// Returns the origin of the path.
    pub(crate) fn path_source(&self) -> MotionSource {
        from(self.machine.source(false))
    }
}

const fn from(source: OrderSource) -> MotionSource {
    match source {
        OrderSource::Task => MotionSource::Task,
        OrderSource::Local => MotionSource::Local,
        OrderSource::Remote => MotionSource::Remote,
    }
}

/// Returns a source as the safety machine knows it.
pub(crate) const fn of(source: MotionSource) -> OrderSource {
    match source {
        MotionSource::Task => OrderSource::Task,
        MotionSource::Local => OrderSource::Local,
        MotionSource::Remote => OrderSource::Remote,
    }
}

//! Realtime. What motion waits for at rest, since when, and whether that ends by itself.

use crate::{path::Parked, setup::MAX_SPINDLES, spindle::Spindle, state::State};
use hal_component::Wait;
use libm::fabs;

/// Share of a commanded speed by which the measured one must come closer to it within [`PROGRESS_NS`], for a ramp.
const PROGRESS: f64 = 1e-3;
const PROGRESS_NS: i64 = 1_000_000_000;

/// The wait in progress.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct WaitInProgress {
    pub(crate) kind: Wait,
    /// Number of the spindle.
    pub(crate) number: i32,
    /// Machine time of its begin in nanoseconds.
    pub(crate) since_ns: i64,
    /// True while the measured speed comes closer to the commanded one.
    pub(crate) is_ramp: bool,
    /// Smallest distance of the speeds so far, and the time at which it was noted.
    closest: f64,
    noted_ns: i64,
}

impl State {
    /// Keeps what motion waits for.
    pub(crate) fn follow_wait(&mut self) {
        let (kind, number) = self.find_wait();
        let now = self.now_ns;
        if (kind, number) != (self.wait.kind, self.wait.number) {
            self.wait = WaitInProgress {
                kind,
                number,
                since_ns: now,
                is_ramp: false,
                closest: f64::INFINITY,
                noted_ns: now,
            };
        }
        if kind != Wait::AtSpeed {
            return;
        }
        let Some(spindle) = usize::try_from(number).ok().and_then(|n| self.spindles.get(n)) else {
            return;
        };
        let commanded = spindle.speed() / 60.0;
        let by = fabs(commanded - spindle.inputs.speed);
        let wait = &mut self.wait;
        if by < wait.closest - PROGRESS * fabs(commanded) {
            // The first distance is no progress.
            wait.is_ramp = wait.closest.is_finite();
            (wait.closest, wait.noted_ns) = (by, now);
        } else if now.wrapping_sub(wait.noted_ns) > PROGRESS_NS {
            wait.is_ramp = false;
        }
    }

    fn find_wait(&self) -> (Wait, i32) {
        if !self.is_on() {
            return (Wait::Nothing, 0);
        }
        let path = &self.path;
        let is_parked = path.parked() != Parked::No;
        if path.is_idle() && !is_parked {
            let turns = self.first_spindle(|spindle| spindle.orientation().0 == 2);
            return turns.map_or((Wait::Nothing, 0), |n| (Wait::Orient, n));
        }
        if path.has_moved() && !is_parked {
            return (Wait::Nothing, 0);
        }
        if path.is_paused() || is_parked {
            let lost = self.lost_spindles();
            return match lost {
                0 => (Wait::Pause, 0),
                _ => (Wait::SpindleStopped, lost.trailing_zeros().cast_signed()),
            };
        }
        if let Some(spindle) = path.awaited_index() {
            return (Wait::Index, number(spindle));
        }
        let turns = path.awaited_turns().and_then(|n| Some((n, self.spindles.get(n)?)));
        if let Some((n, spindle)) = turns {
            let kind = if spindle.at_speed { Wait::SpindleSpeed } else { Wait::AtSpeed };
            return (kind, number(n));
        }
        if let Some(n) = self.first_spindle(|spindle| !spindle.at_speed) {
            return (Wait::AtSpeed, n);
        }
        if let Some(spindle) = path.followed_spindle()
            && self.spindles.get(spindle).is_some_and(|s| s.turns_as_commanded() == 0.0)
        {
            return (Wait::SpindleSpeed, number(spindle));
        }
        match self.feed.held {
            Some(wait) => (wait, 0),
            None if path.is_held_by(&self.feed.net) => (Wait::Override, 0),
            None => (Wait::Nothing, 0),
        }
    }

    fn first_spindle(&self, is: impl Fn(&Spindle) -> bool) -> Option<i32> {
        self.spindles.iter().take(MAX_SPINDLES).position(is).map(number)
    }
}

fn number(spindle: usize) -> i32 {
    i32::try_from(spindle).unwrap_or(0)
}

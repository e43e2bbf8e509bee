//! Changes of motion and the e-stop without the task: the machine goes off, and others stop or pause motion.

use super::{Core, ESTOP, EndedBy, Mode, OFF, Power, STOPPED};
use crate::outside::{Order, Outside};
use hal_component::StopEpoch;

impl Core {
    /// Follows e-stop and the machine's state; a job ends when the machine goes off.
    pub(super) fn watch(&mut self, out: &mut impl Outside) {
        let (io, motion) = (out.io(), out.motion());
        let power = match (io.estop.is_released(), motion.enabled) {
            (false, _) => Power::Estop,
            (true, false) => Power::Off,
            (true, true) => Power::On,
        };
        // Nothing moves in e-stop, whatever is wired.
        if power == Power::Estop && motion.enabled {
            drop(out.order(&Order::Disable, out.epoch()));
        }
        let is_stopped = self.see_stops(motion.epoch);
        let was = core::mem::replace(&mut self.power, power);
        if was == Power::On && power != Power::On {
            let is_estop = power == Power::Estop;
            let (why, by) = if is_estop { (ESTOP, EndedBy::Estop) } else { (OFF, EndedBy::Off) };
            self.note_end(by);
            self.stops = self.stops.wrapping_add(1);
            self.mode = if self.job.is_some() { self.mode } else { Mode::Manual };
            return self.end_job(why, out);
        }
        if is_stopped {
            return self.obey_stop(motion.epoch, out);
        }
        self.obey_pause(motion.epoch);
        if self.job.is_some() && self.rules.needs_homing && !motion.all_homed {
            self.stand_at_move();
            self.fail("a joint is no longer homed", out);
        }
    }

    /// Returns whether motion was stopped by somebody else since it was last asked.
    fn see_stops(&mut self, now: StopEpoch) -> bool {
        // What was before the task began ends nothing of it.
        let is_first = self.seen.stops == 0;
        let is_stopped = !is_first && self.seen.is_stopped_by(now);
        if is_first || is_stopped || self.seen.is_paused_by(now) {
            self.seen = now;
        }
        is_stopped
    }

    /// Motion was stopped: what was given before ends, and coolant and tool change with it.
    fn obey_stop(&mut self, now: StopEpoch, out: &mut impl Outside) {
        self.stops = self.stops.wrapping_add(1);
        if self.ending.is_some() {
            return;
        }
        let given = self.job.as_ref().map(|job| job.given).or_else(|| self.checking.given());
        if given.is_none_or(|given| given.is_stopped_by(now)) {
            self.note_end(EndedBy::Abort);
            self.end_all(STOPPED, true, out);
        }
    }

    /// Motion was paused: a job that was given before rests until it is resumed.
    fn obey_pause(&mut self, now: StopEpoch) {
        if let Some(job) = &mut self.job
            && job.given.is_paused_by(now)
        {
            (job.paused, job.held) = (true, true);
        }
    }

    /// Returns the epoch of the job's orders.
    pub(super) fn job_epoch(&self, out: &impl Outside) -> StopEpoch {
        self.job.as_ref().map_or_else(|| out.epoch(), |job| job.given)
    }

    /// Makes the line of the move in progress that of the next error.
    pub(super) fn stand_at_move(&mut self) {
        if let Some(flight) = self.flight.front() {
            self.current = Some(flight.origin.clone());
        }
    }

    /// Keeps how the job in execution is about to end.
    pub(super) fn note_end(&mut self, by: EndedBy) {
        if self.job.is_some() {
            self.ended_by = by;
        }
    }
}

//! Pauses: a job rests and goes on, as a whole or line by line. A spindle that was stopped meanwhile turns again first.

use super::{
    Asked, Core, Job, Ticket,
    user::{FULL, Report},
};
use crate::outside::{Order, Outside, Progress, Refusal};
use hal_component::StopEpoch;

impl Job {
    /// Lets motion go on, if it was paused or one of its spindles was stopped; what the job orders from now on is given now.
    /// Returns the order to motion, if it takes one.
    ///
    /// # Errors
    /// It cannot go on; the reason.
    fn let_go(&mut self, given: StopEpoch, out: &mut impl Outside) -> Result<Option<u64>, String> {
        let motion = out.motion();
        let inhibited = motion.spindles_stopped & motion.spindles_inhibited;
        if inhibited != 0 {
            let n = inhibited.trailing_zeros();
            let why = format!("spindle.{n}.inhibit is TRUE");
            return Err(format!("spindle {n} was stopped, and cannot turn again: {why}"));
        }
        let mut order = None;
        if self.held || motion.spindles_stopped != 0 {
            match out.order(&Order::Resume, given) {
                Ok(id) => (self.held, order) = (false, Some(id)),
                Err(Refusal::Full) => return Err(FULL.into()),
                Err(Refusal::Why(why)) => return Err(why.into()),
            }
        }
        self.given = given;
        Ok(order)
    }
}

impl Core {
    pub(super) fn pause(&mut self, out: &mut impl Outside) -> Result<Report, String> {
        let Some(job) = &mut self.job else { return Err("nothing runs".into()) };
        if !job.held {
            match out.order(&Order::Pause, out.epoch()) {
                Ok(_) => (job.held, self.seen) = (true, out.epoch()),
                Err(Refusal::Full) => return Err(FULL.into()),
                Err(Refusal::Why(why)) => return Err(why.into()),
            }
        }
        job.paused = true;
        Ok(Report::Now)
    }

    pub(super) fn resume(
        &mut self,
        ticket: Ticket,
        given: StopEpoch,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        let Some(job) = &mut self.job else { return Err("nothing is paused".into()) };
        if !job.paused {
            return Err("nothing is paused".into());
        }
        let order = job.let_go(given, out)?;
        (job.paused, job.stepping) = (false, None);
        self.await_resume(order, ticket, out)
    }

    /// Executes the next line and pauses; without a job, begins the program that way.
    pub(super) fn single_step(
        &mut self,
        ticket: Ticket,
        given: StopEpoch,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        let Some(job) = &mut self.job else { return self.run(ticket, given, true, out) };
        if job.held && !self.flight.is_empty() {
            // Motion is in the middle of a path: it goes on to its next move.
            job.given = given;
            return self.order(&Order::Step, given, ticket, out);
        }
        let order = job.let_go(given, out)?;
        (job.paused, job.stepping) = (false, Some(None));
        self.await_resume(order, ticket, out)
    }

    fn await_resume(
        &mut self,
        order: Option<u64>,
        ticket: Ticket,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        let Some(id) = order else { return Ok(Report::Now) };
        match out.ordered(id) {
            Progress::Pending => {
                self.asked.push((Asked::Resume(id), ticket));
                Ok(Report::Later)
            }
            Progress::Done => Ok(Report::Now),
            Progress::Failed(why) => {
                self.rest_again();
                Err(why)
            }
        }
    }

    /// A program begins: spindles that somebody has stopped stay so, and nothing waits for them.
    pub(super) fn take_stopped_spindles(&mut self, given: StopEpoch, out: &mut impl Outside) {
        let stopped = out.motion().spindles_stopped;
        for spindle in (0u8..8).filter(|n| stopped >> n & 1 != 0) {
            // A queue that is full leaves the wait, which names its end.
            drop(out.order(&Order::Spindle { spindle, speed: 0.0 }, given));
        }
    }

    /// A line of MDI turns a spindle also if somebody has stopped it since the line that turned it before.
    pub(super) fn take_stopped_spindle(&mut self, spindle: u8, out: &mut impl Outside) {
        let is_stopped = out.motion().spindles_stopped >> spindle & 1 != 0;
        if is_stopped && self.job.as_ref().is_some_and(|job| !job.is_program) {
            drop(out.order(&Order::Spindle { spindle, speed: 0.0 }, self.job_epoch(out)));
        }
    }

    /// Motion has refused to go on: the job rests.
    pub(super) fn rest_again(&mut self) {
        if let Some(job) = &mut self.job {
            (job.paused, job.held) = (true, true);
        }
    }
}

//! Waits: the ends of orders and requests, and of the step in execution.

use super::{Asked, Core, Interpreting, Reading, Waiting};
use crate::outside::{Outside, Progress};

impl Core {
    /// Reports the results of orders and requests of commands.
    pub(super) fn report(&mut self, out: &mut impl Outside) {
        let mut waiting = core::mem::take(&mut self.asked);
        let mut has_reset = false;
        waiting.retain(|(asked, ticket)| {
            let progress = match asked {
                Asked::Order(id) | Asked::Resume(id) => out.ordered(*id),
                Asked::Io(id) | Asked::Reset(id) => out.requested(*id),
            };
            let result = match progress {
                Progress::Pending => return true,
                Progress::Done => Ok(()),
                Progress::Failed(why) => Err(why),
            };
            match asked {
                Asked::Resume(_) if result.is_err() => self.rest_again(),
                Asked::Reset(_) => has_reset = true,
                _ => {}
            }
            out.finish(*ticket, result);
            false
        });
        self.asked = waiting;
        if has_reset {
            for (given, ticket) in core::mem::take(&mut self.on_after_reset) {
                if let Err(why) = self.switch_on(given, ticket, out) {
                    out.finish(ticket, Err(why));
                }
            }
        }
    }

    /// Removes the orders that motion has finished. Returns false if one has failed.
    pub(super) fn land(&mut self, out: &mut impl Outside) -> bool {
        while let Some(first) = self.flight.front() {
            match out.ordered(first.id) {
                Progress::Pending => return true,
                Progress::Done => {
                    self.undo.executed(first.origin.serial);
                    self.current = Some(first.origin.clone());
                    self.flight.pop_front();
                }
                Progress::Failed(why) => {
                    self.current = Some(first.origin.clone());
                    self.fail(&why, out);
                    return false;
                }
            }
        }
        true
    }

    /// Follows the request for the next tool. Returns false if it has failed.
    pub(super) fn prepared(&mut self, out: &mut impl Outside) -> bool {
        match self.preparing.map(|id| out.requested(id)) {
            None | Some(Progress::Pending) => {}
            Some(Progress::Done) => self.preparing = None,
            Some(Progress::Failed(why)) => {
                self.preparing = None;
                self.fail(&format!("the tool was not prepared: {why}"), out);
                return false;
            }
        }
        true
    }

    /// Ends the job if the spindle does not reach its speed while a move waits for it.
    pub(super) fn watch_speed(&mut self, out: &mut impl Outside) {
        let motion = out.motion();
        let waits = !self.flight.is_empty() && !motion.at_speed && motion.velocity == 0.0;
        if !waits || self.interpreting() == Interpreting::Paused {
            self.at_speed_since = None;
            return;
        }
        let now = out.now();
        let since = *self.at_speed_since.get_or_insert(now);
        if now - since > self.rules.at_speed_timeout {
            self.at_speed_since = None;
            self.stand_at_move();
            let seconds = self.rules.at_speed_timeout;
            self.fail(&format!("the spindle was not at speed within {seconds} s"), out);
        }
    }

    /// Follows the step in execution. Returns false while it goes on.
    pub(super) fn wait(&mut self, out: &mut impl Outside) -> bool {
        let Some(waiting) = self.waiting.clone() else { return true };
        let paused = self.job.as_ref().is_some_and(|j| j.paused);
        let progress = match waiting {
            Waiting::Order(id) => out.ordered(id),
            Waiting::Io(id) | Waiting::Change { id, .. } => out.requested(id),
            Waiting::Program(_) => out.program(),
            Waiting::Dwell { until } if out.now() >= until && !paused => Progress::Done,
            Waiting::Input { index, analog, mode, until, before } => {
                let mut seen = before;
                let progress = self.input(index, analog, mode, until, &mut seen, out);
                self.waiting = Some(Waiting::Input { index, analog, mode, until, before: seen });
                progress
            }
            Waiting::Oriented { until } => match self.orienting(out) {
                Progress::Pending if out.now() >= until => {
                    Progress::Failed("the spindle was not oriented in time".to_owned())
                }
                other => other,
            },
            Waiting::Dwell { .. } => Progress::Pending,
        };
        match progress {
            Progress::Pending => false,
            Progress::Done => {
                if matches!(waiting, Waiting::Program(_))
                    && let Some(job) = &mut self.job
                {
                    job.user_code = Ok(());
                }
                if let Waiting::Change { tool, .. } = waiting
                    && let Err(why) = self.changed_tool(tool, out)
                {
                    self.fail(&why, out);
                    return false;
                }
                self.waiting = None;
                true
            }
            Progress::Failed(why) if matches!(waiting, Waiting::Program(_)) && self.is_asked() => {
                if let Some(job) = &mut self.job {
                    job.user_code = Err(why);
                }
                self.waiting = None;
                true
            }
            Progress::Failed(why) => {
                self.fail(&why, out);
                false
            }
        }
    }

    /// Returns the seconds that a pause of G4 still takes.
    pub(crate) fn delay_left(&self, now: f64) -> f64 {
        match self.waiting {
            Some(Waiting::Dwell { until }) => (until - now).max(0.0),
            _ => 0.0,
        }
    }

    fn is_asked(&self) -> bool {
        self.job.as_ref().is_some_and(|j| matches!(j.reading, Reading::Asked(_)))
    }

    /// Follows the wait for an input.
    fn input(
        &mut self,
        index: u32,
        analog: bool,
        mode: u8,
        until: f64,
        before: &mut bool,
        out: &mut impl Outside,
    ) -> Progress {
        let motion = out.motion();
        let n = index as usize;
        let on = index < 64 && motion.digital_in >> index & 1 != 0;
        let was = core::mem::replace(before, on);
        let found = match mode {
            1 => on && !was,
            2 => !on && was,
            3 => on,
            4 => !on,
            _ => true,
        };
        let value = match analog {
            true => motion.analog_in.get(n).copied().unwrap_or(0.0),
            false => f64::from(u8::from(on)),
        };
        if found && !value.is_finite() {
            return Progress::Failed(format!(
                "analog input {index} is {value}, which is not a finite number"
            ));
        }
        let is_late = out.now() >= until;
        if let Some(job) = &mut self.job
            && (found || is_late)
        {
            job.input = if found { value } else { -1.0 };
            self.input_was_late = !found;
        }
        if found || is_late { Progress::Done } else { Progress::Pending }
    }

    /// Returns how far the last orientation has come: its order is in flight.
    fn orienting(&self, out: &mut impl Outside) -> Progress {
        self.flight.front().map_or(Progress::Done, |f| out.ordered(f.id))
    }
}

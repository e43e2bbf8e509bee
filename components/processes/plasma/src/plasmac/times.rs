//! Realtime. Times and distances of a job.

use super::{machine::Cutter, state::State};
use hal_component::{Out, Period, Touch};

/// Flag for the start of a job's times.
#[derive(Debug, Default, Touch)]
pub(super) struct Times {
    /// True if a program has run since the last job ended.
    #[state]
    pub(super) begun: bool,
}

fn add(pin: &Out<f64>, by: f64) {
    pin.set(pin.get() + by);
}

impl Cutter {
    /// Adds this cycle to the times of the job.
    pub(super) fn count(&mut self, period: Period) {
        let (status, secs) = (&self.status, period.secs());
        if self.at.is_running.get() {
            self.ran = true;
            if !self.times.begun {
                self.times.begun = true;
                let pins = [
                    &status.run_time,
                    &status.rapid_time,
                    &status.probe_time,
                    &status.torch_time,
                    &status.cut_time,
                    &status.paused_time,
                    &status.cut_length,
                ];
                for pin in pins {
                    pin.set(0.0);
                }
                status.pierce_count.set(0);
                return self.count_acts(period);
            }
        }
        if self.times.begun && (self.at.is_running.get() || self.at.is_paused.get()) {
            add(&status.run_time, secs);
            if self.at.motion_type.get() == 1 {
                add(&status.rapid_time, secs);
            }
        }
        if self.at.is_paused.get() {
            add(&status.paused_time, secs);
        }
        self.count_acts(period);
    }

    /// Adds this cycle to the times of the present activity.
    fn count_acts(&self, period: Period) {
        let (status, secs) = (&self.status, period.secs());
        if self.drive.torch_on.get() {
            add(&status.torch_time, secs);
        }
        if !self.at.is_on.get() {
            return;
        }
        let rises = self.state == State::ProbeUp && (self.touches() || !self.early);
        let falls = self.state == State::ProbeDown && !self.swings();
        if rises || falls || self.state == State::ProbeHeight {
            add(&status.probe_time, secs);
        }
        if matches!(self.state, State::Cut | State::CutByHand) {
            add(&status.cut_time, secs);
            add(&status.cut_length, self.at.velocity.get() * secs);
        }
    }
}

//! Realtime. The times and ways of a job.

use super::{machine::Machine, state::State};
use hal_component::{Out, Period, Touch};

/// Whether a job's times have begun.
#[derive(Debug, Default, Touch)]
pub(super) struct Times {
    /// A program ran since the last end of a job.
    #[state]
    pub(super) begun: bool,
}

fn add(pin: &Out<f64>, by: f64) {
    pin.set(pin.get() + by);
}

impl Machine {
    /// Counts the times of this cycle.
    pub(super) fn count(&mut self, period: Period) {
        let (told, secs) = (&self.told, period.secs());
        if self.at.is_running.get() {
            self.ran = true;
            if !self.times.begun {
                self.times.begun = true;
                let pins = [
                    &told.run_time,
                    &told.rapid_time,
                    &told.probe_time,
                    &told.torch_time,
                    &told.cut_time,
                    &told.paused_time,
                    &told.cut_length,
                ];
                for pin in pins {
                    pin.set(0.0);
                }
                told.pierce_count.set(0);
                return self.count_acts(period);
            }
        }
        if self.times.begun && (self.at.is_running.get() || self.at.is_paused.get()) {
            add(&told.run_time, secs);
            if self.at.motion_type.get() == 1 {
                add(&told.rapid_time, secs);
            }
        }
        if self.at.is_paused.get() {
            add(&told.paused_time, secs);
        }
        self.count_acts(period);
    }

    /// The times of what it does.
    fn count_acts(&self, period: Period) {
        let (told, secs) = (&self.told, period.secs());
        if self.drive.torch_on.get() {
            add(&told.torch_time, secs);
        }
        if !self.at.is_on.get() {
            return;
        }
        let rises = self.state == State::ProbeUp && (self.touches() || !self.early);
        let falls = self.state == State::ProbeDown && !self.swings();
        if rises || falls || self.state == State::ProbeHeight {
            add(&told.probe_time, secs);
        }
        if matches!(self.state, State::Cut | State::CutByHand) {
            add(&told.cut_time, secs);
            add(&told.cut_length, self.at.velocity.get() * secs);
        }
    }
}

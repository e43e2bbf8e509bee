//! Realtime. States 18 and 20 to 22: torch pulse, tests and scribing.

use super::{machine::Cutter, state::State};
use hal_component::Period;

impl Cutter {
    /// Starts a job other than a cut. Returns whether one was requested.
    pub(super) fn begin_job(&mut self) -> bool {
        let drive = &self.drive;
        drive.ohmic_enable.set(self.probe.offset_set_probe.get());
        drive.scribe_arm.set(self.probe.offset_set_scribe.get());
        if self.probe.test.get() {
            drive.feed_hold.set(true);
            self.tests = true;
            self.attempts = 0;
            let touched = self.tip_touches();
            self.status.probe_test_error.set(touched);
            if touched {
                self.go(State::ProbeTest);
            } else if self.aim_probe() {
                self.go(State::ProbeHeight);
            }
        } else if self.jobs.scribe_start.get() {
            self.go(State::Scribing);
        } else if self.cut.torch_pulse_start.get()
            && self.cut.torch_enable.get()
            && self.cut.torch_pulse_time.get() > 0.0
        {
            drive.feed_hold.set(true);
            self.go(State::TorchPulse);
        } else if self.probe.ohmic_test.get() && self.probe.ohmic_probe_enable.get() {
            drive.feed_hold.set(true);
            drive.ohmic_enable.set(true);
            self.go(State::OhmicTest);
        } else {
            return false;
        }
        true
    }

    pub(super) fn ohmic_test(&mut self) {
        if !self.probe.ohmic_test.get() {
            self.drive.ohmic_enable.set(false);
            self.go(State::Idle);
        }
    }

    pub(super) fn probe_test(&mut self) {
        if !self.probe.test.get() {
            self.goal = 0;
            self.toward(self.setup());
            self.along((0, 0), f64::from(self.setup()));
            let drive = &self.drive;
            if [&drive.x_counts, &drive.y_counts, &drive.z_counts].iter().all(|n| n.get() == 0) {
                self.tests = false;
                self.go(State::EndCut);
            }
        }
    }

    pub(super) fn torch_pulse(&mut self, period: Period) {
        if !self.drive.torch_on.get() {
            self.drive.torch_on.set(true);
            self.timer = 0.0;
        } else if self.lasted(self.cut.torch_pulse_time.get(), period) {
            self.drive.torch_on.set(false);
            if !self.cut.torch_pulse_start.get() {
                self.go(State::Idle);
            }
        }
    }

    pub(super) fn scribing(&mut self, period: Period) {
        let drive = &self.drive;
        if !self.jobs.scribe_start.get() {
            drive.scribe_arm.set(false);
            drive.scribe_on.set(false);
            self.go(State::Idle);
        } else if self.at.is_paused.get() {
            drive.scribe_arm.set(false);
            drive.scribe_on.set(false);
            self.timer = 0.0;
        } else {
            let (arm, on) = (self.jobs.scribe_arm_delay.get(), self.jobs.scribe_on_delay.get());
            if !drive.scribe_arm.get() {
                drive.scribe_arm.set(true);
                drive.feed_hold.set(true);
                self.timer = 0.0;
            }
            if !drive.scribe_on.get() {
                if self.lasted(arm, period) {
                    self.drive.scribe_on.set(true);
                    self.timer = 0.0;
                }
            } else if self.lasted(on, period) {
                self.drive.feed_hold.set(false);
            }
        }
    }
}

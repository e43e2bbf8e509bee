//! Realtime. State 0: idle, where cuts and jobs begin.

use super::{
    machine::Cutter,
    state::{State, Stop},
};

impl Cutter {
    pub(super) fn idle(&mut self) {
        if self.drive.z_counts.get() == 0 {
            self.base = self.at.z.get();
        }
        let first = core::mem::take(&mut self.entered);
        let paused = self.at.is_paused.get();
        let sensor = self.status.sensor_active.get();
        let trips = sensor && self.stop == Stop::Fault && !self.at.is_idle.get();
        if self.tripped || trips {
            self.tripped = true;
            if sensor {
                self.drive.program_pause.set(!paused);
                self.go(State::MaxHeight);
                self.max_height();
            } else {
                self.tripped = false;
            }
            return;
        }
        if self.stop == Stop::Fault {
            if paused {
                self.while_paused();
                return;
            }
            let ends = self.at.is_idle.get();
            if self.status.consumable_changing.get() {
                self.go(State::ConsumablesBack);
                if ends {
                    self.consumables_back();
                } else {
                    self.stops(Stop::None);
                }
                return;
            }
            if ends {
                self.end(Stop::Job, State::MaxHeight);
                self.max_height();
                return;
            }
            self.stops(Stop::None);
            self.drive.feed_hold.set(self.at.motion_type.get() != 1);
            self.entered = core::mem::take(&mut self.eases);
            return;
        }
        if !self.at.homed.get() {
            return;
        }
        let has_left = self.laser_leaves();
        if has_left {
            return;
        }
        if sensor && !self.at.is_idle.get() {
            self.tripped = true;
            self.eases = true;
            self.drive.z_enable.set(true);
            self.messages.error("plasmac: a sensor is active before a cut", &[]);
            let stop = if self.stop == Stop::None { Stop::Fault } else { self.stop };
            self.drive.program_pause.set(!paused);
            self.end(stop, State::MaxHeight);
            self.max_height();
            return;
        }
        if matches!(self.stop, Stop::Job | Stop::Cut) && self.at.is_idle.get() {
            self.end(Stop::Job, State::MaxHeight);
            self.max_height();
            return;
        }
        if self.stop == Stop::None && !self.drive.program_pause.get() {
            let has_begun = self.begin_job();
            if has_begun {
                return;
            }
        }
        if self.wanted() && self.stop != Stop::Job {
            self.stops(Stop::None);
            self.drive.feed_hold.set(true);
            if self.drive.program_pause.get() || paused {
                return;
            }
            self.tests = false;
            self.attempts = 0;
            if self.near_last() {
                self.go(State::PierceHeight);
            } else if self.aim_probe() {
                self.go(State::ProbeHeight);
            }
        } else if matches!(self.stop, Stop::None | Stop::Job) && first {
            self.drive.feed_hold.set(false);
        }
    }

    /// Returns whether the torch is so close to the last cut that its surface height can be reused.
    fn near_last(&self) -> bool {
        let distance = self.probe.skip_ihs_distance.get();
        let Some((x, y)) = self.last.filter(|_| distance > 0.0 && self.known) else {
            return false;
        };
        libm::hypot(self.at.x.get() - x, self.at.y.get() - y) < distance
    }

    /// Starts a job that is allowed while a program is paused.
    fn while_paused(&mut self) {
        if self.jobs.paused_motion_speed.get() != 0.0 {
            self.go(State::PausedMotion);
        } else if self.jobs.consumable_change.get() {
            if self.drive.x_counts.get() == 0 && self.drive.y_counts.get() == 0 {
                self.go(State::MaxHeight);
            }
        } else if self.status.consumable_changing.get() {
            self.go(State::ConsumablesBack);
        } else if self.jobs.cut_recovery.get() {
            self.go(State::RecoveryOut);
        }
    }
}

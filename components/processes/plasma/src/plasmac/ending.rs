//! Realtime. Events that end a cut, and states 14 to 17: retract and end.

use super::{
    machine::Cutter,
    state::{State, Stop},
};

impl Cutter {
    /// Ends a cut with this stop reason and enters this state.
    pub(super) fn end(&mut self, stop: Stop, state: State) {
        self.stops(stop);
        self.torch_off();
        self.drive.feed_hold.set(true);
        self.go(state);
    }

    /// Handles a fault: pauses the program and raises the torch to its maximum height.
    pub(super) fn fault(&mut self) {
        self.drive.program_pause.set(!self.at.is_paused.get());
        self.end(Stop::Fault, State::MaxHeight);
        self.max_height();
    }

    /// Handles events from outside that end a cut. Returns whether one did.
    pub(super) fn interrupted(&mut self) -> bool {
        let ends = matches!(self.state, State::MaxHeight | State::EndCut);
        if ends && self.stop == Stop::None && self.at.is_idle.get() && !self.wanted() {
            self.end(Stop::Job, State::MaxHeight);
            self.max_height();
            return true;
        }
        if !(State::ProbeHeight..=State::PauseAtEnd).contains(&self.state) {
            return false;
        }
        let touched = self.probe.float_switch.get()
            && (State::CutHeight..=State::CutByHand).contains(&self.state)
            && !self.at.is_idle.get();
        let shorted = self.tip_touches() && self.state == State::Cut;
        let low = f64::from(self.thc.low_cut_volts.get());
        let dim = low > 0.0 && self.status.thc_active.get() && self.now < low;
        let broken = self.probe.breakaway.get() && !self.at.is_idle.get();
        if broken || touched || shorted {
            self.tripped = true;
            self.eases = false;
            self.messages.error("plasmac: a sensor is active", &[]);
            self.fault();
        } else if dim {
            let volts = [self.now, low];
            self.messages.error("plasmac: {} V are below low-cut-volts, {}", &volts);
            self.fault();
        } else if self.at.is_paused.get() {
            self.fault();
        } else if self.ran && self.at.is_idle.get() {
            self.end(Stop::Job, State::MaxHeight);
            self.max_height();
        } else if self.tests {
            if self.probe.test.get() {
                return false;
            }
            self.go(State::ProbeTest);
        } else if self.probe.test.get() {
            return false;
        } else if !self.wanted() && self.state != State::PauseAtEnd {
            if self.state >= State::Cut {
                self.last = Some((self.at.x.get(), self.at.y.get()));
            }
            if self.at.is_idle.get() {
                self.end(Stop::Job, State::MaxHeight);
                self.max_height();
            } else if self.state < State::PauseAtEnd && self.cut.pause_at_end.get() > 0.0 {
                self.stops(Stop::Cut);
                self.drive.feed_hold.set(true);
                self.go(State::PauseAtEnd);
                return false;
            } else {
                self.end(Stop::Cut, State::SafeHeight);
            }
        } else if self.lost() {
            self.messages.error("plasmac: the arc is lost", &[]);
            self.fault();
        } else {
            return false;
        }
        true
    }

    pub(super) fn safe_height(&mut self) {
        self.status.cornerlock.set(false);
        if self.known && self.entered {
            let safe = self.cut.safe_height.get();
            #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
            let most = self.highest as i32;
            self.goal = if safe > 0.0 { self.above(safe).min(most) } else { most };
            self.entered = false;
        }
        if !self.known {
            self.goal = 0;
        }
        if self.toward(self.setup()) {
            self.drive.feed_hold.set(false);
            self.go(State::EndCut);
        }
    }

    pub(super) fn max_height(&mut self) {
        self.status.cornerlock.set(false);
        self.goal = 0;
        let up = self.toward(self.setup());
        let back = up && self.along((0, 0), f64::from(self.setup()));
        if back && !self.probe.test.get() {
            if self.stop == Stop::Cut {
                self.drive.feed_hold.set(false);
            }
            let paused = self.stop == Stop::Fault && self.at.is_paused.get();
            self.go(if paused && self.jobs.consumable_change.get() {
                State::ConsumablesOut
            } else if paused && self.jobs.cut_recovery.get() {
                State::RecoveryOut
            } else {
                State::EndCut
            });
        }
    }

    pub(super) fn end_cut(&mut self) {
        self.status.target_volts.set(0.0);
        self.status.probe_test_error.set(false);
        self.control.begin();
        self.status.led_up.set(false);
        self.status.led_down.set(false);
        self.drive.cutting_stop.set(false);
        self.drive.ohmic_enable.set(false);
        self.go(if self.at.is_idle.get() { State::EndJob } else { State::Idle });
    }

    pub(super) fn end_job(&mut self) {
        self.goal = 0;
        if self.at.is_idle.get() && self.toward(self.setup()) {
            self.stops(Stop::None);
            self.ran = false;
            self.times.begun = false;
            self.go(State::Idle);
        }
    }
}

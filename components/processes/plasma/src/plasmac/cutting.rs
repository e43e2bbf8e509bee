//! Realtime. States 6 to 13: torch on, pierce and cut.

use super::{
    machine::Cutter,
    numbers::{later, short, sooner, sum},
    state::{State, Stop},
};
use hal_component::Period;

impl Cutter {
    /// Returns whether the cut runs without a program.
    pub(super) fn is_manual(&self) -> bool {
        self.at.is_idle.get()
    }

    pub(super) fn torch_on(&mut self, period: Period) {
        if self.stop == Stop::Cut {
            self.stops(Stop::None);
        }
        if self.starts >= self.arc.max_starts.get() {
            self.restart = 0.0;
            if self.is_manual() {
                self.drive.cutting_stop.set(true);
                self.go(State::MaxHeight);
            } else {
                self.drive.program_pause.set(true);
            }
            if self.entered {
                self.entered = false;
                self.messages.error("plasmac: no arc after {} starts", &[f64::from(self.starts)]);
            }
            return;
        }
        if self.restart > 0.0 {
            self.restart = sooner(self.restart, period);
            if self.restart > 0.0 {
                return;
            }
        }
        if self.cut.torch_enable.get() {
            self.starts = self.starts.saturating_add(1);
            self.status.pierce_count.set(self.status.pierce_count.get().wrapping_add(1));
            self.drive.torch_on.set(true);
        }
        self.spot = None;
        self.go(State::ArcOk);
    }

    pub(super) fn arc_ok(&mut self, period: Period) {
        let failed = self.waited(self.arc.fail_delay.get(), period);
        let spots = self.jobs.spotting_start.get() && !self.jobs.cutting_start.get();
        if spots {
            self.spotting(period);
        }
        if failed {
            self.drive.torch_on.set(false);
            self.restart = short(self.arc.restart_delay.get());
            self.go(State::TorchOn);
        } else if !spots && (self.status.arc_ok.get() || self.ignores_arc()) {
            self.go(State::PierceDelay);
        }
    }

    /// Runs a spot. Its time counts from when the voltage first reaches the threshold, with or without an arc.
    fn spotting(&mut self, period: Period) {
        if let Some(time) = self.spot {
            let time = later(time, period);
            self.spot = Some(time);
            if f64::from(time) * 1000.0 >= self.jobs.spotting_time.get() {
                self.drive.torch_on.set(false);
                self.stops(Stop::Cut);
                self.go(State::SafeHeight);
            }
        } else if self.now >= self.jobs.spotting_threshold.get() {
            self.spot = Some(0.0);
        }
    }

    /// Returns whether the arc is lost although the cut needs it.
    pub(super) fn lost(&self) -> bool {
        let ignores = self.ignores_arc() || self.cut.mesh_enable.get();
        let needs = self.cut.torch_enable.get() && !ignores && !self.is_manual();
        let cuts = (State::PierceDelay..=State::CutByHand).contains(&self.state);
        cuts && needs && !self.status.arc_ok.get() && !self.cut.torch_off.get()
    }

    pub(super) fn pierce_delay(&mut self, period: Period) {
        if self.lasted(self.cut.pierce_delay.get(), period) {
            let height = self.cut.puddle_jump_height.get();
            let moves = height > 0.0 && height != 100.0;
            let jumps = moves || self.cut.puddle_jump_delay.get() > 0.0;
            self.go(if jumps && !self.recovers { State::PuddleJump } else { State::CutHeight });
        }
    }

    pub(super) fn puddle_jump(&mut self, period: Period) {
        self.drive.feed_hold.set(false);
        let height = self.cut.puddle_jump_height.get();
        if height > 0.0 {
            self.aim(self.cut.pierce_height.get() * height / 100.0);
        }
        if self.toward(self.setup()) && self.lasted(self.cut.puddle_jump_delay.get(), period) {
            self.go(State::CutHeight);
        }
    }

    pub(super) fn cut_height(&mut self) {
        self.aim(self.cut.cut_height.get());
        if self.toward(self.setup()) {
            // After a cut that ended because the machine was turned off, the old target stays, as in LinuxCNC.
            if self.control.waits() {
                self.control.begin();
            }
            if self.recovers {
                self.go(State::RecoveryBack);
                return;
            }
            self.drive.feed_hold.set(false);
            self.go(if self.cut.mode.get() == 2 { State::CutByHand } else { State::Cut });
        }
    }

    pub(super) fn cutting(&mut self, period: Period) {
        self.ask_feed();
        let most = self.speed(self.thc.feed_rate.get());
        let auto = self.thc.auto.get() && self.thc.use_auto_volts.get();
        let steady = (auto && self.control.waits()).then(|| self.steady.mean(&self.thc));
        let settings = (&self.thc, &self.cut);
        let meshes = self.cut.mesh_enable.get();
        let ignores = self.arc.ignore_ok_0.get() || self.arc.ignore_ok_1.get();
        if !self.drive.torch_on.get() || meshes || ignores {
            return;
        }
        let may = self.status.thc_enabled.get();
        let now = (self.now, f64::from(most), may, period);
        let moves = (self.drive.offset_scale.get(), self.setup());
        let by = self.control.step(settings, &self.at, &self.status, moves, steady, now);
        if by != 0.0 {
            let now = sum(self.drive.z_counts.get(), by);
            self.drift = self.drift.max(now.saturating_sub(self.goal));
            self.drive.z_counts.set(now);
        }
    }

    /// Publishes the feed rate that the program requests, and applies the program's feed reduction.
    fn ask_feed(&self) {
        let reduced = self.at.feed_reduction.get();
        let feed = if (10.0..100.0).contains(&reduced) { reduced / 100.0 } else { 1.0 };
        self.drive.adaptive_feed.set(feed);
        let wanted = self.at.feed_upm.get() / self.at.gcode_scale.get() / feed;
        self.status.requested_feed_rate.set(wanted);
    }

    pub(super) fn by_hand(&mut self) {
        self.ask_feed();
        let active = self.status.thc_enabled.get() && self.drive.torch_on.get();
        self.control.active = active;
        self.status.thc_active.set(active);
        let (down, up) = (self.thc.move_down.get(), self.thc.move_up.get());
        let down = active && down;
        let up = active && up && !down;
        self.status.led_up.set(up);
        self.status.led_down.set(down);
        let most = f64::from(self.speed(self.thc.feed_rate.get()));
        #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
        let by = (most * self.thc.p_gain.get() / 100.0) as i32;
        if up {
            self.shift(by);
        } else if down {
            self.shift(by.saturating_neg());
        }
    }

    pub(super) fn pause_at_end(&mut self, period: Period) {
        if self.waited(self.cut.pause_at_end.get(), period) {
            self.drive.torch_on.set(false);
            self.stops(Stop::Cut);
            self.go(State::SafeHeight);
        }
    }
}

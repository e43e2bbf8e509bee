//! Realtime. States 19, 23 and 24: what is done while a program is paused.

use super::{
    machine::Machine,
    state::{State, Stop},
};

impl Machine {
    pub(super) fn paused_motion(&mut self) {
        let speed = self.jobs.paused_motion_speed.get();
        let drive = &self.drive;
        if self.at.is_idle.get() {
            self.told.paused_motion.set(false);
            drive.program_resume.set(false);
            self.end(Stop::Job, State::EndCut);
        } else if speed != 0.0 {
            self.told.paused_motion.set(true);
            drive.program_resume.set(true);
            drive.feed_hold.set(false);
            drive.adaptive_feed.set(speed);
        } else if self.at.is_running.get() {
            drive.adaptive_feed.set(1.0);
            drive.feed_hold.set(true);
            drive.program_resume.set(false);
            drive.program_pause.set(true);
        } else if !drive.program_resume.get() {
            self.told.paused_motion.set(false);
            drive.program_pause.set(false);
            self.go(State::RecoveryOut);
        }
    }

    pub(super) fn consumables_out(&mut self) {
        if self.entered {
            self.told.consumable_changing.set(true);
            self.drive.xy_enable.set(true);
            self.entered = false;
            return;
        }
        if self.at.is_idle.get() {
            self.go(State::ConsumablesBack);
            self.consumables_back();
            return;
        }
        if !self.jobs.consumable_change.get() {
            self.go(State::Idle);
            return;
        }
        if self.touches() || self.probe.breakaway.get() {
            return;
        }
        let goal = (self.jobs.x_offset.get(), self.jobs.y_offset.get());
        if self.along(goal, self.pace(self.jobs.xy_feed_rate.get())) {
            self.go(State::Idle);
        }
    }

    pub(super) fn consumables_back(&mut self) {
        if self.along((0, 0), self.pace(self.jobs.xy_feed_rate.get())) {
            self.told.consumable_changing.set(false);
            self.drive.feed_hold.set(false);
            self.go(State::Idle);
        }
    }

    /// Moves X and Y one step along the line to the goal: whether they were there.
    pub(super) fn along(&self, goal: (i32, i32), speed: f64) -> bool {
        let drive = &self.drive;
        let now = (drive.x_counts.get(), drive.y_counts.get());
        let left = (f64::from(goal.0) - f64::from(now.0), f64::from(goal.1) - f64::from(now.1));
        if left == (0.0, 0.0) {
            return true;
        }
        let far = libm::hypot(left.0, left.1);
        if far > speed {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "shorter than the way that is left"
            )]
            let step = ((left.0 / far * speed) as i32, (left.1 / far * speed) as i32);
            drive.x_counts.set(now.0.saturating_add(step.0));
            drive.y_counts.set(now.1.saturating_add(step.1));
        } else {
            drive.x_counts.set(goal.0);
            drive.y_counts.set(goal.1);
        }
        false
    }
}

//! Realtime. States 19, 23 and 24: paused motion and consumable change.

use super::{
    machine::Cutter,
    state::{State, Stop},
};

impl Cutter {
    pub(super) fn paused_motion(&mut self) {
        let speed = self.jobs.paused_motion_speed.get();
        let drive = &self.drive;
        if self.at.is_idle.get() {
            self.status.paused_motion.set(false);
            drive.program_resume.set(false);
            self.end(Stop::Job, State::EndCut);
        } else if speed != 0.0 {
            self.status.paused_motion.set(true);
            drive.program_resume.set(true);
            drive.feed_hold.set(false);
            drive.adaptive_feed.set(speed);
        } else if self.at.is_running.get() {
            drive.adaptive_feed.set(1.0);
            drive.feed_hold.set(true);
            drive.program_resume.set(false);
            drive.program_pause.set(true);
        } else if !drive.program_resume.get() {
            self.status.paused_motion.set(false);
            drive.program_pause.set(false);
            self.go(State::RecoveryOut);
        }
    }

    pub(super) fn consumables_out(&mut self) {
        if self.entered {
            self.status.consumable_changing.set(true);
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
            self.status.consumable_changing.set(false);
            self.drive.feed_hold.set(false);
            self.go(State::Idle);
        }
    }

    /// Moves X and Y one step along the line from the present offsets to the goal. Returns whether they were already
    /// there.
    pub(super) fn along(&self, goal: (i32, i32), speed: f64) -> bool {
        let now = (self.drive.x_counts.get(), self.drive.y_counts.get());
        self.across(now, goal, speed)
    }

    /// Moves X and Y one step along the line between two positions. Each axis stops at its goal. Returns whether both
    /// were already there.
    pub(super) fn across(&self, from: (i32, i32), goal: (i32, i32), speed: f64) -> bool {
        let line = (away(from.0, goal.0), away(from.1, goal.1));
        let far = libm::hypot(line.0, line.1);
        let mut was_there = true;
        for (counts, part, goal) in
            [(&self.drive.x_counts, line.0, goal.0), (&self.drive.y_counts, line.1, goal.1)]
        {
            let left = away(counts.get(), goal);
            was_there &= left == 0.0;
            let step = if far > speed { libm::trunc(part / far * speed) } else { left };
            #[expect(
                clippy::cast_possible_truncation,
                reason = "no more than the way that is left"
            )]
            let next = counts.get().saturating_add(step as i32);
            counts.set(if step == 0.0 || left.abs() <= step.abs() { goal } else { next });
        }
        was_there
    }
}

/// Returns the signed distance from one count to another.
fn away(from: i32, goal: i32) -> f64 {
    f64::from(goal) - f64::from(from)
}

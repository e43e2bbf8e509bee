//! Realtime. States 25 and 26: move to the position where the cut resumes, then back to the path.

use super::{
    machine::Cutter,
    numbers::{short, sum},
    state::State,
};

impl Cutter {
    pub(super) fn recovery_out(&mut self) {
        self.status.cut_recovering.set(true);
        self.drive.xy_enable.set(true);
        self.recovers = true;
        if !self.at.is_paused.get() && self.at.is_running.get() {
            self.go(State::Idle);
            return;
        }
        if self.at.is_idle.get() {
            self.go(State::RecoveryBack);
            self.recovery_back();
            return;
        }
        if !self.jobs.cut_recovery.get() {
            self.go(State::RecoveryBack);
            return;
        }
        let mut goal = (self.jobs.x_offset.get(), self.jobs.y_offset.get());
        let state = self.status.laser_recovery_state.get();
        if state == 3 {
            goal = self.by_laser(goal);
        } else if self.jobs.laser_recovery_start.get() >= 1 {
            if state < 2 {
                self.status.laser_recovery_state.set(state + 1);
                self.laser = self.by_laser((self.drive.x_counts.get(), self.drive.y_counts.get()));
            } else if self.along(self.laser, self.pace(self.cut.cut_feed_rate.get())) {
                self.status.laser_recovery_state.set(3);
            }
            return;
        }
        let half = f64::from(short(self.pace(self.cut.cut_feed_rate.get()))) / 2.0;
        let step = |now: i32, goal: i32| {
            let left = f64::from(goal) - f64::from(now);
            if left.abs() <= half { goal } else { sum(now, half.copysign(left)) }
        };
        self.drive.x_counts.set(step(self.drive.x_counts.get(), goal.0));
        self.drive.y_counts.set(step(self.drive.y_counts.get(), goal.1));
    }

    /// Returns these offsets plus the laser offset, in counts.
    fn by_laser(&self, (x, y): (i32, i32)) -> (i32, i32) {
        let jobs = &self.jobs;
        (x.saturating_add(jobs.laser_x_offset.get()), y.saturating_add(jobs.laser_y_offset.get()))
    }

    /// Removes the laser offset before the cut resumes. Returns whether the laser was in use.
    pub(super) fn laser_leaves(&mut self) -> bool {
        let state = self.status.laser_recovery_state.get();
        if state == 3 {
            self.status.laser_recovery_state.set(4);
        } else if state == 4 {
            self.status.laser_recovery_state.set(5);
        } else if state == 5 {
            let goal = (self.jobs.x_offset.get(), self.jobs.y_offset.get());
            if self.along(goal, self.pace(self.cut.cut_feed_rate.get())) {
                self.status.laser_recovery_state.set(0);
            }
        }
        state > 2
    }

    pub(super) fn recovery_back(&mut self) {
        let cuts = self.drive.torch_on.get();
        let speed = self.pace(self.cut.cut_feed_rate.get());
        if self.along((0, 0), if cuts { speed } else { speed / 2.0 }) {
            self.status.cut_recovering.set(false);
            self.status.laser_recovery_state.set(0);
            self.recovers = false;
            if self.at.is_paused.get() {
                self.go(State::Idle);
            } else {
                self.drive.feed_hold.set(false);
                self.go(State::Cut);
            }
        }
    }
}

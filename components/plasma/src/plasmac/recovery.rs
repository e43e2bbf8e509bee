//! Realtime. States 25 and 26: to where a cut goes on, and back to the path.

use super::{machine::Machine, numbers::sum, state::State};

impl Machine {
    pub(super) fn recovery_out(&mut self) {
        self.told.cut_recovering.set(true);
        self.drive.xy_enable.set(true);
        self.recovers = true;
        if !self.at.is_paused.get() && self.at.is_running.get() {
            self.go(State::Idle);
            return;
        }
        if !self.jobs.cut_recovery.get() {
            self.go(State::RecoveryBack);
            return;
        }
        let goal = (self.jobs.x_offset.get(), self.jobs.y_offset.get());
        if self.jobs.laser_recovery_start.get() >= 1 && self.told.laser_recovery_state.get() < 3 {
            let state = self.told.laser_recovery_state.get();
            if state < 2 {
                self.told.laser_recovery_state.set(state + 1);
                return;
            }
            let goal = (
                self.drive.x_counts.get().saturating_add(self.jobs.laser_x_offset.get()),
                self.drive.y_counts.get().saturating_add(self.jobs.laser_y_offset.get()),
            );
            if self.along(goal, self.pace(self.cut.cut_feed_rate.get())) {
                self.told.laser_recovery_state.set(3);
            }
            return;
        }
        let half = self.pace(self.cut.cut_feed_rate.get()) / 2.0;
        let step = |now: i32, goal: i32| {
            let left = f64::from(goal) - f64::from(now);
            if left.abs() <= half { goal } else { sum(now, half.copysign(left)) }
        };
        self.drive.x_counts.set(step(self.drive.x_counts.get(), goal.0));
        self.drive.y_counts.set(step(self.drive.y_counts.get(), goal.1));
    }

    pub(super) fn recovery_back(&mut self) {
        let cuts = self.drive.torch_on.get();
        let speed = self.pace(self.cut.cut_feed_rate.get());
        if self.along((0, 0), if cuts { speed } else { speed / 2.0 }) {
            self.told.cut_recovering.set(false);
            self.told.laser_recovery_state.set(0);
            self.recovers = false;
            self.drive.feed_hold.set(false);
            self.go(if cuts { State::Cut } else { State::Idle });
        }
    }
}

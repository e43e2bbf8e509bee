//! Realtime. Offset probe: moves X and Y so that the probe replaces the torch, and moves them back.

use super::{machine::Cutter, numbers::later, state::Stop};
use hal_component::{Period, Touch};

/// Number of counts up to which the last step back takes no cycle of its own.
const NEAR: u32 = 1000;

/// State of an offset probe.
#[derive(Default, Touch)]
pub(super) struct Offset {
    /// X and Y offsets of the probing position, in counts.
    #[state]
    goal: (i32, i32),
    /// X and Y offsets at the start of the cut, in counts.
    #[state]
    home: (i32, i32),
    /// Seconds since the move began.
    #[state]
    moved: f32,
}

impl Cutter {
    /// Sets the probing position for a cut that begins. Returns false, and reports a fault, if the position is beyond a
    /// limit of X or Y.
    pub(super) fn aim_probe(&mut self) -> bool {
        self.offset = Offset::default();
        let (x, y) = (self.probe.offset_x.get(), self.probe.offset_y.get());
        if !self.probe.ohmic_probe_enable.get() || (x == 0.0 && y == 0.0) {
            return true;
        }
        let (at_x, at_y) = (self.at.x.get() + x, self.at.y.get() + y);
        if at_x > self.at.x_max.get()
            || at_x < self.at.x_min.get()
            || at_y > self.at.y_max.get()
            || at_y < self.at.y_min.get()
        {
            self.messages.error(
                "plasmac: the offset probe would be at X {} and Y {}, beyond a limit",
                &[at_x, at_y],
            );
            self.drive.program_pause.set(!self.at.is_paused.get());
            self.drive.feed_hold.set(true);
            self.stops(Stop::Fault);
            return false;
        }
        let scale = self.drive.offset_scale.get();
        #[expect(clippy::cast_possible_truncation, reason = "what does not fit is at its end")]
        let there = |now: i32, far: f64| (f64::from(now) + far / scale) as i32;
        let (now_x, now_y) = (self.drive.x_counts.get(), self.drive.y_counts.get());
        self.offset.home = (now_x, now_y);
        self.offset.goal = (there(now_x, x), there(now_y, y));
        true
    }

    /// Returns whether this cut uses the offset probe.
    fn is_offset(&self) -> bool {
        self.probe.ohmic_probe_enable.get() && self.offset.goal != self.offset.home
    }

    /// Moves X and Y one step toward the probing position. Returns whether they were already there.
    pub(super) fn probe_out(&mut self, period: Period) -> bool {
        if !self.is_offset() {
            return true;
        }
        self.drive.xy_enable.set(true);
        self.offset.moved = later(self.offset.moved, period);
        self.across(self.offset.home, self.offset.goal, f64::from(self.setup()))
    }

    /// Returns whether X and Y are at the probing position.
    pub(super) fn is_there(&self) -> bool {
        let drive = &self.drive;
        !self.is_offset() || (drive.x_counts.get(), drive.y_counts.get()) == self.offset.goal
    }

    /// Returns whether the probe is still extending or retracting.
    pub(super) fn swings(&self) -> bool {
        f64::from(self.offset.moved) < self.probe.offset_delay.get() && self.is_offset()
    }

    /// Returns whether the probe is extended, and counts this cycle.
    pub(super) fn is_out(&mut self, period: Period) -> bool {
        let swings = self.swings();
        self.offset.moved = later(self.offset.moved, period);
        !swings
    }

    /// Moves X and Y one step back to the torch position. Returns whether they are there, and whether the probe is
    /// retracted.
    pub(super) fn probe_back(&mut self, period: Period) -> (bool, bool) {
        if !self.is_offset() {
            return (true, true);
        }
        if self.entered {
            self.offset.moved = 0.0;
        }
        self.offset.moved = later(self.offset.moved, period);
        let Offset { home, goal, .. } = self.offset;
        let drive = &self.drive;
        let left = [(&drive.x_counts, home.0), (&drive.y_counts, home.1)];
        let near = left.iter().all(|(counts, home)| counts.get().abs_diff(*home) <= NEAR);
        let was_there = self.across(goal, home, f64::from(self.setup()));
        let arrives = near && left.iter().all(|(counts, home)| counts.get() == *home);
        (was_there || arrives, !self.swings())
    }
}

//! Realtime. Progress along the current move, for pins and the snapshot.

use super::{Path, less};
use hal_component::Pose;
use hal_trajectory::{Group, Step};
use libm::{atan2, fabs};

/// Turn of a step that is rounding, in radians.
const STRAIGHT: f64 = 1e-9;

impl Path {
    /// Returns the distance travelled along the current move, and the velocity along the path, negative in reverse.
    pub(crate) fn along(&self) -> (f64, f64) {
        if self.current().is_none() {
            return (0.0, 0.0);
        }
        (self.travelled, libm::copysign(self.velocity, self.last.travel))
    }

    /// Returns the programmed speed of the current move within the machine's limits, and with the override.
    pub(crate) fn feeds(&self) -> (f64, f64) {
        let Step { lead, feed, highest, .. } = self.last;
        let (feed, highest) = (lead * feed, lead * highest);
        let Some(current) = self.current() else { return (0.0, 0.0) };
        (less(feed, highest), less(feed * current.kind.scale(&self.scales), highest))
    }

    /// Returns the distance to the end of the current move: of XYZ, else of UVW, else of ABC.
    pub(crate) fn distance_to_go(&self) -> f64 {
        let Some(known) = self.current() else { return 0.0 };
        if known.length > 0.0 {
            let left = known.length - self.travelled;
            return if left > 0.0 { left } else { 0.0 };
        }
        let by = hal_trajectory::Pose(known.end) - self.last.pose;
        let mut ways = [Group::Xyz, Group::Uvw, Group::Abc].into_iter().map(|g| by.norm(g));
        ways.find(|way| *way > 0.0).unwrap_or(0.0)
    }

    /// Returns the distance of each axis to the end of the current move.
    pub(crate) fn axis_to_go(&self) -> Pose {
        let Some(known) = self.current() else { return [0.0; 9] };
        (hal_trajectory::Pose(known.end) - self.last.pose).0
    }

    /// Keeps the direction of this step in x and y.
    pub(super) fn turn_heading(&mut self, step: &Step) {
        let [x, y, ..] = (step.pose - self.last.pose).0;
        // The first step of a path has no place before it.
        if !self.last.moving || !step.moving || x == 0.0 && y == 0.0 {
            return;
        }
        // Along a line the direction stays.
        let [was_x, was_y] = self.direction;
        let (across, along) = (was_x * y - was_y * x, was_x * x + was_y * y);
        let is_straight = fabs(across) <= STRAIGHT * along && along > 0.0;
        if !is_straight {
            self.direction = [x, y];
            self.heading = atan2(y, x).to_degrees();
        }
    }

    /// Returns the direction of the path in x and y, and the one to its left, in degrees.
    pub(crate) fn headings(&self) -> (f64, f64) {
        let left = self.heading + 90.0;
        (self.heading, if left > 180.0 { left - 360.0 } else { left })
    }

    /// Returns centre and radius of the current arc; zeros without one.
    pub(crate) fn circle(&self) -> ([f64; 3], f64) {
        self.current().map_or(([0.0; 3], 0.0), |c| c.circle)
    }
}

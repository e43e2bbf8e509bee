//! The moves in a hole, from its clearance level to the level after it.

use super::cycle::Hole;
use crate::{
    axis::Axis,
    canon::{Call, Direction, Unit},
    error::Problem,
    interpret::{Run, block::Block, codes::shown},
};

impl Run<'_> {
    /// Makes the moves of one hole.
    pub(super) fn drill(&mut self, code: u16, hole: Hole, b: &Block) -> Result<(), Problem> {
        match code {
            810 => {
                self.down(hole, hole.bottom)?;
                self.up(hole, hole.clear)
            }
            820 => {
                self.down(hole, hole.bottom)?;
                self.cycle_dwell(code)?;
                self.up(hole, hole.clear)
            }
            830 | 730 => self.peck(hole, code),
            740 | 840 => self.tap(hole, code, b),
            850 => {
                self.down(hole, hole.bottom)?;
                self.down(hole, hole.r)?;
                self.up(hole, hole.clear)
            }
            860 => {
                let direction = self.turning(code)?;
                self.down(hole, hole.bottom)?;
                self.cycle_dwell(code)?;
                self.turn(0, Direction::Stopped)?;
                self.up(hole, hole.clear)?;
                self.turn(0, direction)
            }
            870 => self.back_bore(hole),
            880 => {
                let direction = self.turning(code)?;
                self.down(hole, hole.bottom)?;
                self.cycle_dwell(code)?;
                self.turn(0, Direction::Stopped)?;
                self.emit(Call::ProgramStop)?;
                self.turn(0, direction)
            }
            _ => {
                self.down(hole, hole.bottom)?;
                self.cycle_dwell(code)?;
                self.down(hole, hole.clear)
            }
        }
    }

    fn down(&mut self, hole: Hole, level: f64) -> Result<(), Problem> {
        let mut to = self.state.position;
        to[hole.axis] = level;
        self.feed(to)
    }

    fn up(&mut self, hole: Hole, level: f64) -> Result<(), Problem> {
        let mut to = self.state.position;
        to[hole.axis] = level;
        self.rapid(to)
    }

    /// Checks the words and the spindle of a cycle before its first hole.
    pub(super) fn check_drill(&self, code: u16) -> Result<(), Problem> {
        let cycle = &self.state.cycle;
        match code {
            820 | 860 | 880 | 890 if cycle.p.is_none() => {
                Err(Problem::CycleDwell { code: shown(code) })
            }
            730 | 830 => match cycle.q {
                None => Err(Problem::CycleQ { code: shown(code) }),
                Some(q) if q <= 0.0 => Err(Problem::CycleQNegative { code: shown(code) }),
                Some(_) => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn cycle_dwell(&mut self, code: u16) -> Result<(), Problem> {
        let seconds = self.state.cycle.p.ok_or(Problem::CycleDwell { code: shown(code) })?;
        self.emit(Call::Dwell(seconds))
    }

    fn direction(&self) -> Direction {
        self.state.modal.spindles.first().map_or(Direction::Stopped, |s| s.direction)
    }

    /// Returns the spindle's direction, which must not be a stop.
    fn turning(&self, code: u16) -> Result<Direction, Problem> {
        match self.direction() {
            Direction::Stopped => Err(Problem::SpindleOff { code: shown(code) }),
            direction => Ok(direction),
        }
    }

    fn peck(&mut self, hole: Hole, code: u16) -> Result<(), Problem> {
        let missing = Problem::CycleQ { code: shown(code) };
        let step = self.state.cycle.q.ok_or(missing)?;
        let gap = match self.state.frame.unit {
            Unit::Inch => 0.010,
            Unit::Millimetre => 0.254,
        };
        let mut level = hole.r - step;
        // A step that is lost in the level's digits would never reach the bottom.
        let mut passes = 0u32;
        while level > hole.bottom {
            passes += 1;
            if passes > 1_000_000 {
                return Err(Problem::OutputTooLarge { limit: 1_000_000 });
            }
            self.down(hole, level)?;
            if code == 830 {
                self.up(hole, hole.r)?;
            }
            self.up(hole, level + gap)?;
            level -= step;
        }
        self.down(hole, hole.bottom)?;
        self.up(hole, hole.clear)
    }

    fn tap(&mut self, hole: Hole, code: u16, b: &Block) -> Result<(), Problem> {
        let spindle = self.spindle(b, "G74 or G84")?.unwrap_or(0);
        let of = self.state.modal.spindles.get(usize::from(spindle)).copied();
        let direction = of.map_or(Direction::Stopped, |s| s.direction);
        let (wanted, back) = if code == 840 {
            (Direction::Clockwise, Direction::Counterclockwise)
        } else {
            (Direction::Counterclockwise, Direction::Clockwise)
        };
        if direction == Direction::Stopped {
            return Err(Problem::SpindleOff { code: shown(code) });
        }
        if direction != wanted {
            return Err(match code {
                840 => Problem::SpindleCcw { code: shown(code) },
                _ => Problem::SpindleCw { code: shown(code) },
            });
        }
        let (feed_override, speed_override) =
            (self.state.modal.feed_override, of.is_some_and(|s| s.speed_override));
        self.set_feed_override(false)?;
        self.set_speed_override(spindle, false)?;
        self.down(hole, hole.bottom)?;
        self.turn(spindle, Direction::Stopped)?;
        self.turn(spindle, back)?;
        self.emit(Call::Dwell(self.state.cycle.p.unwrap_or(0.0)))?;
        self.down(hole, hole.clear)?;
        self.turn(spindle, Direction::Stopped)?;
        self.turn(spindle, wanted)?;
        if feed_override {
            self.set_feed_override(true)?;
        }
        if speed_override {
            self.set_speed_override(spindle, true)?;
        }
        Ok(())
    }

    /// Bores from behind: down beside the axis, up at the axis, and back.
    fn back_bore(&mut self, hole: Hole) -> Result<(), Problem> {
        let direction = self.turning(870)?;
        let [i, j, k] = self.state.cycle.ijk;
        let (first, second) = match hole.axis {
            Axis::Z | Axis::W => (i, j),
            Axis::Y | Axis::V => (k, i),
            _ => (j, k),
        };
        let (f, s, _) = self.state.modal.plane.axes();
        let centre = self.state.position;
        let mut beside = centre;
        beside[f] += first;
        beside[s] += second;
        let middle = match hole.axis {
            Axis::Z | Axis::W => k,
            Axis::Y | Axis::V => j,
            _ => i,
        };
        let middle = if self.state.modal.absolute { middle } else { hole.bottom + middle };
        self.rapid(beside)?;
        self.turn(0, Direction::Stopped)?;
        self.emit(Call::OrientSpindle { spindle: 0, degrees: 0.0, mode: 2 })?;
        beside[hole.axis] = hole.bottom;
        self.rapid(beside)?;
        self.back_to(centre, f, s)?;
        self.turn(0, direction)?;
        self.down(hole, middle)?;
        self.down(hole, hole.bottom)?;
        self.turn(0, Direction::Stopped)?;
        self.emit(Call::OrientSpindle { spindle: 0, degrees: 0.0, mode: 2 })?;
        beside[hole.axis] = hole.bottom;
        self.rapid(beside)?;
        beside[hole.axis] = hole.clear;
        self.rapid(beside)?;
        self.back_to(centre, f, s)?;
        self.turn(0, direction)
    }

    fn back_to(&mut self, centre: crate::axis::Position, f: Axis, s: Axis) -> Result<(), Problem> {
        let mut to = self.state.position;
        (to[f], to[s]) = (centre[f], centre[s]);
        self.rapid(to)
    }
}

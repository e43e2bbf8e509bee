//! Canned cycles: their sticky words, checks, and the moves between holes.

use crate::{
    axis::{Axis, Position},
    canon::{Call, PathMode, Plane},
    error::Problem,
    interpret::{Run, block::Block},
    state::FeedMode,
};

/// A hole: levels along the cycle's axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    /// The axis.
    pub(crate) axis: Axis,
    /// The clearance level.
    pub(crate) r: f64,
    /// The bottom.
    pub(crate) bottom: f64,
    /// The level after the hole.
    pub(crate) clear: f64,
}

/// The names of a plane in messages, its drilling axis and the axes that may not move.
fn plane_names(plane: Plane) -> (&'static str, char) {
    match plane {
        Plane::Xy => ("xy", 'z'),
        Plane::Xz => ("xz", 'y'),
        Plane::Yz => ("yz", 'x'),
        Plane::Uv => ("uv", 'w'),
        Plane::Uw => ("uw", 'v'),
        Plane::Vw => ("vw", 'u'),
    }
}

impl Run<'_> {
    pub(super) fn cycle(&mut self, b: &Block, code: u16) -> Result<(), Problem> {
        if self.state.modal.feed_mode == FeedMode::InverseTime {
            return Err(Problem::CycleInverse);
        }
        let plane = self.state.modal.plane;
        self.check_cycle_axes(b, plane)?;
        if self.state.compensation.is_on() {
            return Err(Problem::CycleComp);
        }
        if self.state.modal.feed == 0.0 {
            return Err(Problem::ZeroFeedCycle);
        }
        let repeats = match b.integer(b'l')? {
            None => 1,
            Some(0) => return Err(Problem::CycleRepeats),
            Some(l) => u32::try_from(l).map_err(|_| Problem::NegativeWord { letter: 'L' })?,
        };
        self.sticky_words(b, code, plane)?;
        let (first, second, axis) = plane.axes();
        let cycle = self.state.cycle;
        let (r, bottom) = if self.state.modal.absolute {
            (cycle.r, cycle.bottom)
        } else {
            let r = cycle.r + cycle.initial;
            (r, r + cycle.bottom)
        };
        if r < bottom {
            let (plane, letter) = plane_names(plane);
            return Err(Problem::CycleR { letter, plane });
        }
        if cycle.initial < r {
            let mut up = self.state.position;
            up[axis] = r;
            self.rapid(up)?;
        }
        let clear =
            if self.state.modal.retract_old && cycle.initial > r { cycle.initial } else { r };
        let hole = Hole { axis, r, bottom, clear };
        let (path, naive) = (self.state.modal.path, self.state.modal.naive_tolerance);
        if path != PathMode::ExactPath {
            self.emit(Call::SetPathMode(PathMode::ExactPath))?;
        }
        self.check_drill(code)?;
        for _ in 0..repeats {
            let mut at = self.state.position;
            for side in [first, second] {
                if let Some(v) = b.get(side.letter() as u8) {
                    at[side] = if self.state.modal.absolute { v } else { at[side] + v };
                }
            }
            if b.has_any(b"@^") {
                (at.x, at.y) = self.polar(b, at)?;
            }
            at[axis] = if at[axis] > clear { at[axis] } else { clear };
            self.rapid(at)?;
            if at[axis] > r {
                at[axis] = r;
                self.rapid(at)?;
            }
            self.drill(code, hole, b)?;
        }
        if path != PathMode::ExactPath {
            self.set_path(path, naive)?;
        }
        Ok(())
    }

    fn check_cycle_axes(&self, b: &Block, plane: Plane) -> Result<(), Problem> {
        let xyz = matches!(plane, Plane::Xy | Plane::Xz | Plane::Yz);
        let others: &[u8] = if xyz { b"abcuvw" } else { b"abcxyz" };
        match others.iter().find(|l| b.has(**l)) {
            Some(letter) => Err(Problem::CycleAxis { letter: char::from(*letter) }),
            None => Ok(()),
        }
    }

    /// Takes the words of the line over those of the chain.
    fn sticky_words(&mut self, b: &Block, code: u16, plane: Plane) -> Result<(), Problem> {
        let (.., axis) = plane.axes();
        let bottom = b.get(axis.letter() as u8);
        let r = b.get(b'r');
        let motion = self.state.modal.motion;
        let cycle = &mut self.state.cycle;
        // Another cycle, or one after other motion, needs its own words; the level where the chain began stays.
        if cycle.active != Some(code) || motion != code {
            let (plane, letter) = plane_names(plane);
            if r.is_none() {
                return Err(Problem::CycleRMissing);
            }
            if bottom.is_none() {
                return Err(Problem::CycleZMissing { letter, plane });
            }
            // The dwell of a tapping cycle is that of the last P of any cycle.
            match code {
                820 | 860 | 880 | 890 => cycle.p = None,
                730 | 830 => cycle.q = None,
                _ => {}
            }
        }
        if !in_cycle(motion) {
            cycle.initial = self.state.position[axis];
        }
        cycle.active = Some(code);
        cycle.r = r.unwrap_or(cycle.r);
        cycle.bottom = bottom.unwrap_or(cycle.bottom);
        cycle.p = b.get(b'p').or(cycle.p);
        cycle.q = b.get(b'q').or(cycle.q);
        let [i, j, k] = &mut cycle.ijk;
        for (letter, value) in [(b'i', i), (b'j', j), (b'k', k)] {
            *value = b.get(letter).unwrap_or(*value);
        }
        Ok(())
    }

    /// Makes a rapid move.
    pub(crate) fn rapid(&mut self, to: Position) -> Result<(), Problem> {
        self.emit(Call::StraightTraverse(to))?;
        self.state.position = to;
        Ok(())
    }

    /// Makes a move at feed.
    pub(crate) fn feed(&mut self, to: Position) -> Result<(), Problem> {
        self.emit(Call::StraightFeed(to))?;
        self.state.position = to;
        Ok(())
    }
}

/// Tells whether a motion is a canned cycle.
pub(crate) fn in_cycle(motion: u16) -> bool {
    matches!(motion, 730 | 740 | 810..=890)
}

//! Straight moves: the axis with the longest way steps in each tick, the others when their error asks for it.

use super::{Place, Step};

/// The ticks of a straight move.
#[derive(Clone, Debug)]
pub struct Line {
    /// The steps of each axis without their sign.
    ways: [i64; 3],
    signs: Step,
    /// The axis that steps in each tick: the first of the longest ones.
    master: usize,
    longest: i64,
    errors: [i64; 3],
    done: i64,
}

/// Returns the ticks from a place to the place `delta` steps away.
pub fn line(delta: Place) -> Line {
    let ways = delta.map(i64::abs);
    let longest = ways.into_iter().fold(0, i64::max);
    let master = ways.iter().position(|w| *w == longest).unwrap_or(0);
    let signs = delta.map(|d| i8::try_from(d.signum()).unwrap_or(0));
    Line { ways, signs, master, longest, errors: [0; 3], done: 0 }
}

impl Line {
    /// Returns the number of ticks that are left.
    pub fn remaining(&self) -> u64 {
        (self.longest - self.done).unsigned_abs()
    }
}

impl Iterator for Line {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        if self.done >= self.longest {
            return None;
        }
        self.done += 1;
        let mut step = [0; 3];
        let axes = step.iter_mut().zip(self.ways).zip(self.signs).zip(&mut self.errors);
        for (axis, (((step, way), sign), error)) in axes.enumerate() {
            if axis == self.master {
                *step = sign;
                continue;
            }
            *error += 2 * way;
            if *error >= self.longest {
                *step = sign;
                *error -= 2 * self.longest;
            }
        }
        Some(step)
    }
}

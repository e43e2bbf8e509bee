//! The figures of a whole program in ticks.

use super::{Move, MoveKind, Place, Step};

/// Sums over all ticks and moves of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// The ticks.
    pub ticks: u64,
    /// The ticks that step one, two and three axes.
    pub by_axes: [u64; 3],
    /// The steps of each axis, in either direction.
    pub steps: [u64; 3],
    /// The place after the last tick, in steps from the begin.
    pub place: Place,
    /// The lowest place of each axis.
    pub low: Place,
    /// The highest place of each axis.
    pub high: Place,
    /// The moves G00, G01, G02 and G03.
    pub moves: [u64; 4],
    /// The length of the path in inches.
    pub length: f64,
    /// The seconds of all ticks.
    pub seconds: f64,
}

impl Figures {
    /// Adds a tick.
    pub fn step(&mut self, step: Step) {
        self.ticks += 1;
        let mut axes = 0_usize;
        let places = self.place.iter_mut().zip(&mut self.low).zip(&mut self.high);
        for (((place, low), high), (moved, steps)) in places.zip(step.iter().zip(&mut self.steps)) {
            if *moved != 0 {
                axes += 1;
                *steps += 1;
            }
            *place += i64::from(*moved);
            *low = (*low).min(*place);
            *high = (*high).max(*place);
        }
        if let Some(count) = axes.checked_sub(1).and_then(|n| self.by_axes.get_mut(n)) {
            *count += 1;
        }
    }

    /// Adds a move, beside its ticks.
    pub fn moved(&mut self, by: &Move) {
        let kind = match by.kind {
            MoveKind::Rapid => 0,
            MoveKind::Line => 1,
            MoveKind::Clockwise => 2,
            MoveKind::Counterclockwise => 3,
        };
        if let Some(count) = self.moves.get_mut(kind) {
            *count += 1;
        }
        self.length += by.length;
        self.seconds += by.seconds * by.ticks as f64;
    }
}

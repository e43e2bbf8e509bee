//! The levels of cuts, and the walls at which they end.

use super::contour::Piece;
use crate::error::Problem;

/// The most levels of a cycle.
const MAX_LEVELS: u32 = 100_000;

/// The levels of cuts: `top`, and each `increment` below it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    pub(super) top: f64,
    increment: f64,
}

impl Levels {
    /// Returns the levels of a cycle along some pieces.
    ///
    /// # Errors
    /// The levels are too many.
    pub(super) fn new(top: f64, increment: f64, parts: &[Piece]) -> Result<Self, Problem> {
        let ends = || parts.iter().flat_map(|p| [p.from.second, p.to.second]);
        let lowest = ends().fold(top, f64::min);
        let highest = ends().fold(top, f64::max);
        if (highest - lowest) / increment < f64::from(MAX_LEVELS) {
            Ok(Self { top, increment })
        } else {
            Err(Problem::ProfileLevels { limit: MAX_LEVELS })
        }
    }

    /// Iterates over the levels from `high`, included, down to `low`, which is none.
    pub(super) fn between(self, high: f64, low: f64) -> impl Iterator<Item = f64> {
        let index = |level: f64| libm::ceil((self.top - level) / self.increment - 1e-9).max(0.0);
        let (first, end) = (index(high), index(low));
        (0..=MAX_LEVELS)
            .map(move |n| first + f64::from(n))
            .take_while(move |index| *index < end)
            .map(move |index| self.top - index * self.increment)
    }
}

/// The highest ends of pieces, to find the first one from a piece on that reaches a level: a tree in which each
/// element has the higher value of the two below it.
#[derive(Debug)]
pub(super) struct Peaks {
    tree: Vec<f64>,
    leaves: usize,
}

impl Peaks {
    pub(super) fn new(parts: &[Piece]) -> Self {
        let leaves = parts.len().max(1).next_power_of_two();
        let mut tree = vec![f64::NEG_INFINITY; leaves];
        tree.extend(parts.iter().map(|p| p.to.second));
        tree.resize(2 * leaves, f64::NEG_INFINITY);
        let mut out = Self { tree, leaves };
        for index in (1..leaves).rev() {
            let value = out.at(2 * index).max(out.at(2 * index + 1));
            if let Some(element) = out.tree.get_mut(index) {
                *element = value;
            }
        }
        out
    }

    fn at(&self, index: usize) -> f64 {
        self.tree.get(index).copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// Returns the first piece from `from` on whose end reaches a level.
    pub(super) fn first_at(&self, from: usize, level: f64) -> Option<usize> {
        if from >= self.leaves {
            return None;
        }
        let mut index = self.leaves + from;
        // Up and to the right, to the first element that reaches the level.
        while self.at(index) < level {
            while index % 2 == 1 {
                index /= 2;
            }
            if index == 0 {
                return None;
            }
            index += 1;
        }
        while index < self.leaves {
            index = if self.at(2 * index) >= level { 2 * index } else { 2 * index + 1 };
        }
        Some(index - self.leaves)
    }
}

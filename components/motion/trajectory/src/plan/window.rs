//! The limit of cells that the follower passes in a period.

/// Lengths of the last cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    lengths: [f64; Self::CELLS],
    next: usize,
}

impl Default for Window {
    fn default() -> Self {
        Self { lengths: [1e9; Self::CELLS], next: 0 }
    }
}

impl Window {
    /// Largest number of cells that the follower passes in one period.
    const CELLS: usize = 8;

    /// Adds a cell and returns the length of the last cells together.
    pub(super) fn add(&mut self, length: f64) -> f64 {
        if let Some(slot) = self.lengths.get_mut(self.next) {
            *slot = length;
        }
        self.next = (self.next + 1) % Self::CELLS;
        self.lengths.iter().sum()
    }
}

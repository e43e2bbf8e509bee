//! Realtime. Output pins that change seldom: a group is written when one of its values has changed.
//!
//! The engine keeps a pin's value when the pin is linked, and passes it to the signal. A value that is the same as in
//! the last cycle need not be written again.

/// Values that a group of pins shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<const N: usize> {
    values: [u64; N],
    known: bool,
}

impl<const N: usize> Default for Shown<N> {
    fn default() -> Self {
        Self { values: [0; N], known: false }
    }
}

impl<const N: usize> Shown<N> {
    /// Keeps the values of this cycle; returns whether they must be written.
    #[inline]
    pub(crate) fn changes(&mut self, values: [u64; N]) -> bool {
        let differs = |bits, (a, b): (&u64, &u64)| bits | (a ^ b);
        let changed = !self.known || values.iter().zip(&self.values).fold(0, differs) != 0;
        if changed {
            *self = Self { values, known: true };
        }
        changed
    }
}

/// Returns bits as a number, the first as the lowest.
#[inline]
pub(crate) fn packed<const N: usize>(bits: [bool; N]) -> u64 {
    const { assert!(N <= 32) };
    bits.iter().rev().fold(0, |sum, bit| sum << 1 | u64::from(*bit))
}

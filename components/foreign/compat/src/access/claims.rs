//! Realtime. Set of the real ports that components have claimed: one bit for each of the 65,536 ports.

use core::{iter, ops::Range};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Number of ports, and of ports in a word.
const PORTS: u32 = 1 << 16;
const BITS: u32 = u64::BITS;

/// Claimed ports.
#[derive(Debug)]
pub(crate) struct Claims([AtomicU64; (PORTS / BITS) as usize]);

impl Claims {
    /// Returns the empty set.
    pub(crate) const fn new() -> Self {
        Self([const { AtomicU64::new(0) }; (PORTS / BITS) as usize])
    }

    /// Adds `count` ports from `base` on.
    pub(crate) fn add(&self, base: u16, count: u16) {
        let base = u32::from(base);
        for port in base..PORTS.min(base + u32::from(count)) {
            if let Some(word) = self.0.get((port / BITS) as usize) {
                word.fetch_or(1 << (port % BITS), Relaxed);
            }
        }
    }

    /// Iterates over the claimed ports, as ranges without neighbours.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = Range<u32>> {
        let mut at = 0;
        iter::from_fn(move || {
            let start = self.next(at, true)?;
            at = self.next(start, false).unwrap_or(PORTS);
            Some(start..at)
        })
    }

    /// Returns the first port from `from` on that is claimed, or that is not.
    fn next(&self, from: u32, claimed: bool) -> Option<u32> {
        let mut port = from;
        while let Some(word) = self.0.get((port / BITS) as usize) {
            let word = word.load(Relaxed);
            let wanted = if claimed { word } else { !word } >> (port % BITS);
            if wanted != 0 {
                return Some(port + wanted.trailing_zeros());
            }
            port = (port / BITS + 1) * BITS;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::Claims;

    #[test]
    fn every_claim_is_kept() {
        let claims = Claims::new();
        assert_eq!(claims.ranges().count(), 0);
        for base in (0..u16::MAX).step_by(64) {
            claims.add(base, 3);
        }
        let ranges: Vec<_> = claims.ranges().collect();
        let wanted: Vec<_> = (0..65_535).step_by(64).map(|base| base..base + 3).collect();
        assert_eq!(ranges, wanted);
    }

    #[test]
    fn neighbours_are_joined() {
        let claims = Claims::new();
        for (base, count) in [(0x378, 8), (0x380, 8), (0x37a, 3), (0xfffe, 100), (7, 0)] {
            claims.add(base, count);
        }
        assert_eq!(claims.ranges().collect::<Vec<_>>(), [0x378..0x388, 0xfffe..0x1_0000]);
        claims.add(0, u16::MAX);
        assert!(claims.ranges().eq(core::iter::once(0..0x1_0000)));
    }
}

//! A set of numbers, for states that were visited.

/// The set: open addressing, at most half full.
#[derive(Debug)]
pub(crate) struct Visited {
    places: Vec<u128>,
    len: usize,
}

impl Visited {
    pub(crate) fn new() -> Self {
        Self { places: vec![u128::MAX; 1 << 16], len: 0 }
    }

    /// Adds a number; returns false if it was there.
    pub(crate) fn insert(&mut self, key: u128) -> bool {
        if self.len * 2 > self.places.len() {
            let bigger = Self { places: vec![u128::MAX; self.places.len() * 4], len: 0 };
            let old = core::mem::replace(self, bigger);
            for key in old.places.into_iter().filter(|k| *k != u128::MAX) {
                self.insert(key);
            }
        }
        let mask = self.places.len() - 1;
        let mixed = key.wrapping_mul(0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835);
        let mut at = usize::try_from(mixed >> 72).unwrap_or(0) & mask;
        loop {
            match self.places[at] {
                u128::MAX => break,
                there if there == key => return false,
                _ => at = (at + 1) & mask,
            }
        }
        self.places[at] = key;
        self.len += 1;
        true
    }
}

//! Indices of names: which node has which name.
//!
//! An index stores a hash of each name and the node. The nodes hold the names. A machine may have a
//! million of them, and most scripts name each a few times.

use crate::graph::Ix;
use core::hash::{Hash, Hasher};
use hashbrown::HashTable;
use std::hash::DefaultHasher;

/// An index of names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Index {
    Components,
    Pins,
    Params,
    Signals,
    Functs,
    Threads,
    Commands,
}

impl Index {
    /// Returns the index of pins or of parameters.
    pub(crate) const fn of_items(param: bool) -> Self {
        if param { Self::Params } else { Self::Pins }
    }
}

/// The names of one kind of node.
#[derive(Debug, Default)]
pub(crate) struct Names(HashTable<Entry>);

/// A name of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    hash: u32,
    ix: Ix,
}

impl Entry {
    fn new(name: &str, ix: Ix) -> Self {
        Self { hash: hash(name), ix }
    }
}

/// Returns the hash of a name, without a random key. Only look-ups depend on it.
#[expect(clippy::cast_possible_truncation, reason = "any 32 bits of a hash are a hash")]
pub(super) fn hash(name: &str) -> u32 {
    let mut hasher = DefaultHasher::new();
    name.hash(&mut hasher);
    hasher.finish() as u32
}

/// Spreads a hash over the bits that the table reads.
fn spread(hash: u32) -> u64 {
    u64::from(hash).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

impl Names {
    /// Returns the number of names.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds a name of a node.
    pub(crate) fn insert(&mut self, name: &str, ix: Ix) {
        let new = Entry::new(name, ix);
        self.0.insert_unique(spread(new.hash), new, |e| spread(e.hash));
    }

    /// Removes a name, if it belongs to the node. Returns whether it did.
    pub(crate) fn remove(&mut self, name: &str, ix: Ix) -> bool {
        let old = Entry::new(name, ix);
        match self.0.find_entry(spread(old.hash), |e| *e == old) {
            Ok(entry) => {
                entry.remove();
                true
            }
            Err(_) => false,
        }
    }

    /// Returns the hash of each name, with its node.
    pub(super) fn hashes(&self) -> impl Iterator<Item = (u32, Ix)> {
        self.0.iter().map(|e| (e.hash, e.ix))
    }

    /// Returns the node with a name; `has` tells whether a node has it.
    pub(super) fn find(&self, name: &str, has: impl Fn(Ix) -> bool) -> Option<Ix> {
        let hash = hash(name);
        self.0.find(spread(hash), |e| e.hash == hash && has(e.ix)).map(|e| e.ix)
    }
}

#[cfg(test)]
mod tests {
    use super::Names;
    use crate::graph::Ix;

    #[test]
    fn a_name_belongs_to_one_node_until_it_is_removed() {
        let mut names = Names::default();
        let (old, new) = (Ix::new(1), Ix::new(2));
        names.insert("x", old);
        assert_eq!(names.find("x", |ix| ix == old), Some(old));
        assert_eq!(names.find("y", |_| true), None);
        assert!(!names.remove("x", new));
        names.insert("x", new);
        assert!(names.remove("x", old) && !names.remove("x", old));
        assert_eq!((names.find("x", |_| true), names.len()), (Some(new), 1));
    }
}

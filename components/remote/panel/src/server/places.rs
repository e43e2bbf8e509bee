//! Places of connections: nobody has all of them.

use super::MAX_CONNECTIONS;
use crate::limits::SignInPlace;
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Number of connections from one address, or of one user of this computer.
pub(super) const MAX_OWN: usize = MAX_CONNECTIONS / 2;

/// Number of connections from each place.
#[derive(Clone, Debug, Default)]
pub(super) struct Places(Arc<Mutex<BTreeMap<SignInPlace, usize>>>);

/// A place that a connection has until it ends.
#[derive(Debug)]
pub(super) struct Place {
    places: Places,
    source: SignInPlace,
}

impl Places {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<SignInPlace, usize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a place for a connection, unless those from there have too many.
    pub(super) fn take(&self, source: SignInPlace) -> Option<Place> {
        let mut taken = self.lock();
        let own = taken.entry(source.clone()).or_default();
        if *own >= MAX_OWN {
            return None;
        }
        *own += 1;
        drop(taken);
        Some(Place { places: self.clone(), source })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = self.places.lock();
        let left = taken.get(&self.source).map_or(0, |own| own - 1);
        if left == 0 {
            taken.remove(&self.source);
        } else {
            taken.insert(self.source.clone(), left);
        }
    }
}

#[cfg(test)]
mod tests {
    //! Connections of strangers beside those of a person.

    use super::{MAX_OWN, Places, SignInPlace};

    #[test]
    fn a_stranger_has_half_of_all_connections() {
        let places = Places::default();
        let take = |user| places.take(SignInPlace::User(user));
        let all: Vec<_> = (0..MAX_OWN).map(|_| take(65_534).unwrap()).collect();
        assert!(take(65_534).is_none());
        assert!(take(1000).is_some());
        drop(all);
        assert!(take(65_534).is_some());
        assert!(places.lock().is_empty());
    }
}

//! Places of connections: nobody has all of them.

use super::MAX_CONNECTIONS;
use crate::limits::SignInPlace;
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Number of connections of one user of this computer.
pub(super) const MAX_OWN: usize = MAX_CONNECTIONS / 2;
/// Number of connections from one address, behind which many people may be.
pub(super) const MAX_ADDRESS: usize = MAX_CONNECTIONS / 8;
/// Number of connections from all addresses: the others are for people at this computer.
pub(super) const MAX_NETWORK: usize = MAX_CONNECTIONS / 8 * 7;

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
        let is_network = |place: &SignInPlace| matches!(place, SignInPlace::Address(_));
        let all = |taken: &BTreeMap<SignInPlace, usize>| -> usize {
            taken.iter().filter(|(place, _)| is_network(place)).map(|(_, count)| count).sum()
        };
        let most = if is_network(&source) { MAX_ADDRESS } else { MAX_OWN };
        let is_full = is_network(&source) && all(&taken) >= MAX_NETWORK;
        if is_full || taken.get(&source).is_some_and(|own| *own >= most) {
            return None;
        }
        *taken.entry(source.clone()).or_default() += 1;
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

    use super::{MAX_ADDRESS, MAX_CONNECTIONS, MAX_NETWORK, MAX_OWN, Places, SignInPlace};

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

    #[test]
    fn a_few_addresses_have_a_part_of_them_and_all_addresses_leave_some() {
        let places = Places::default();
        let all = |text: &str| -> Vec<_> {
            let source = SignInPlace::at(text.parse().unwrap());
            core::iter::from_fn(|| places.take(source.clone())).collect()
        };
        let two = [all("192.0.2.1"), all("192.0.2.2")];
        assert_eq!(two.each_ref().map(Vec::len), [MAX_ADDRESS; 2]);
        // Of IPv6, a network is an address.
        let six = all("2001:db8::1");
        assert_eq!((six.len(), all("2001:db8::2").len()), (MAX_ADDRESS, 0));
        let person = all("192.0.2.3");
        assert_eq!(person.len(), MAX_ADDRESS, "somebody else is served");
        let others: Vec<_> = (4..30).flat_map(|n| all(&format!("192.0.2.{n}"))).collect();
        let count = two.iter().flatten().count() + six.len() + person.len() + others.len();
        assert_eq!(count, MAX_NETWORK);
        let here: Vec<_> = core::iter::from_fn(|| places.take(SignInPlace::User(1000))).collect();
        assert!(MAX_CONNECTIONS - MAX_NETWORK <= here.len(), "{}", here.len());
        drop((two, six, person, others, here));
        assert!(places.lock().is_empty());
    }
}

//! Seats of connections, and of clients of the engine: nobody has all of them.

use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Number of connections at once, whatever the options say.
pub(crate) const MAX_SESSIONS: usize = 256;
/// Number of sessions that have a client of the engine, which has 256 for all programs.
const MAX_LINKED: usize = 128;
/// Parts of all connections that other users of this computer have, each and together.
const EACH: usize = 8;
const TOGETHER: usize = 2;

/// The other end of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Who {
    /// The user of this program, or root.
    Own,
    /// Another user, by their number; `None` if the system does not say.
    Other(Option<u32>),
}

/// Purpose of a seat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Purpose {
    Connection(Who),
    Link,
}

/// The seats.
#[derive(Clone, Debug)]
pub(crate) struct Seats {
    taken: Arc<Mutex<BTreeMap<Purpose, usize>>>,
    most: usize,
}

/// A seat until it is dropped.
#[derive(Debug)]
pub(crate) struct Taken {
    seats: Seats,
    kind: Purpose,
}

impl Seats {
    /// Returns seats for so many connections, and for no more than there can be.
    pub(crate) fn new(most: usize) -> Self {
        Self { taken: Arc::default(), most: most.min(MAX_SESSIONS) }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<Purpose, usize>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a seat for a connection, unless there are too many, or too many of its user.
    pub(crate) fn connect(&self, who: Who) -> Option<Taken> {
        let mut taken = self.lock();
        let count = |fits: &dyn Fn(Who) -> bool| -> usize {
            let of = |kind: &Purpose| matches!(kind, Purpose::Connection(who) if fits(*who));
            taken.iter().filter(|(kind, _)| of(kind)).map(|(_, count)| count).sum()
        };
        let is_free = match who {
            Who::Own => true,
            // One at least: with few seats, who has the password has one.
            Who::Other(_) => {
                count(&|other| other == who) < (self.most / EACH).max(1)
                    && count(&|other| other != Who::Own) < (self.most / TOGETHER).max(1)
            }
        };
        let is_free = is_free && count(&|_| true) < self.most;
        is_free.then(|| self.take(&mut taken, Purpose::Connection(who)))
    }

    /// Takes a seat for a client of the engine.
    pub(crate) fn link(&self) -> Option<Taken> {
        let mut taken = self.lock();
        let is_free = taken.get(&Purpose::Link).is_none_or(|count| *count < MAX_LINKED);
        is_free.then(|| self.take(&mut taken, Purpose::Link))
    }

    fn take(&self, taken: &mut BTreeMap<Purpose, usize>, kind: Purpose) -> Taken {
        *taken.entry(kind).or_default() += 1;
        Taken { seats: self.clone(), kind }
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        let mut taken = self.seats.lock();
        match taken.get_mut(&self.kind) {
            Some(count) if *count > 1 => *count -= 1,
            _ => drop(taken.remove(&self.kind)),
        }
    }
}

#[cfg(test)]
mod tests {
    //! Connections of strangers beside those of the machine's user.

    use super::{MAX_LINKED, MAX_SESSIONS, Seats, Who};

    #[test]
    fn strangers_take_neither_all_seats_nor_all_clients() {
        let seats = Seats::new(usize::MAX);
        let all =
            |seats: &Seats, who| -> Vec<_> { core::iter::from_fn(|| seats.connect(who)).collect() };
        let first = all(&seats, Who::Other(Some(7)));
        assert_eq!(first.len(), MAX_SESSIONS / 8, "of one user");
        let others: Vec<_> = (8..30).flat_map(|user| all(&seats, Who::Other(Some(user)))).collect();
        assert_eq!(first.len() + others.len(), MAX_SESSIONS / 2, "of all strangers");
        assert!(seats.connect(Who::Other(None)).is_none());
        let own = all(&seats, Who::Own);
        assert_eq!(own.len(), MAX_SESSIONS / 2);
        drop(first);
        assert_eq!(all(&seats, Who::Other(None)).len(), MAX_SESSIONS / 8);
        drop((own, others));
        assert!(seats.lock().is_empty(), "{seats:?}");
        let linked: Vec<_> = core::iter::from_fn(|| seats.link()).collect();
        assert_eq!(linked.len(), MAX_LINKED);
    }

    #[test]
    fn with_one_seat_whoever_comes_has_it() {
        let seats = Seats::new(1);
        let taken = seats.connect(Who::Other(Some(7)));
        assert!(taken.is_some() && seats.connect(Who::Own).is_none());
        drop(taken);
        assert!(seats.connect(Who::Own).is_some());
    }
}

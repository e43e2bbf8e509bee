//! Work for those who look: paths of programs and pictures of the wiring. Each person has a few seats, all work takes turns on
//! one processor, a turn is short, and work whose request has gone ends at its next look.

use crate::error::{Code, Error};
use core::fmt;
use std::{
    collections::{BTreeMap, VecDeque},
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    time::Duration,
};
use tokio::{task::spawn_blocking, time::Instant};

/// Seats of all, and of one person. A seat is kept until the answer has been sent.
pub(crate) const MAX_SEATS: usize = 64;
const MAX_OWN_SEATS: usize = 4;
/// Longest turn while others wait.
const TURN: Duration = Duration::from_millis(50);
/// Longest time that a piece of work may take for itself, without its waits.
const MAX_TIME: Duration = Duration::from_secs(60);
/// Memory of all in bytes, and that which each may take whatever others have.
const MAX_MEMORY: usize = 1 << 30;
const OWN_MEMORY: usize = 16 << 20;

/// Reason why a piece of work does not go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limit {
    /// Nobody waits for the work any more.
    Gone,
    /// Time for the work is over.
    Time,
    /// Memory that is left is less than the work wants.
    Memory,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gone => f.write_str("nobody waits for it any more"),
            Self::Time => write!(f, "reading it takes more than {} s", MAX_TIME.as_secs()),
            Self::Memory => f.write_str("it takes more memory than is left for pictures and paths"),
        }
    }
}

impl From<Limit> for Error {
    fn from(limit: Limit) -> Self {
        let code = if limit == Limit::Gone { Code::Conflict } else { Code::TooLarge };
        Self::new(code, limit.to_string())
    }
}

/// Time of the clock of a pool.
type Clock = Box<dyn Fn() -> Duration + Send + Sync>;

/// The pool.
#[derive(Clone)]
pub(crate) struct Pool(Arc<Room>);

struct Room {
    state: Mutex<PoolState>,
    /// Notified when a turn ends, and when a request goes.
    changed: Condvar,
    clock: Clock,
}

#[derive(Debug, Default)]
struct PoolState {
    /// Seats that each person has.
    seats: BTreeMap<String, usize>,
    memory: usize,
    /// Number of the work whose turn it is.
    turn: Option<u64>,
    /// Numbers of the work that waits for its turn.
    line: VecDeque<u64>,
    numbers: u64,
}

impl fmt::Debug for Pool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.lock().fmt(f)
    }
}

impl Default for Pool {
    fn default() -> Self {
        let begun = Instant::now();
        Self::on(Box::new(move || begun.elapsed()))
    }
}

impl Pool {
    fn on(clock: Clock) -> Self {
        let (state, changed) = (Mutex::default(), Condvar::new());
        Self(Arc::new(Room { state, changed, clock }))
    }

    /// Takes a seat for a person, by the name of [`Session::seated`](crate::session::Session::seated).
    pub(crate) fn seat(&self, user: &str) -> Result<Seat, Error> {
        let mut state = self.0.lock();
        let own = state.seats.get(user).copied().unwrap_or(0);
        if own >= MAX_OWN_SEATS || state.seats.values().sum::<usize>() >= MAX_SEATS {
            let text = format!("at most {MAX_OWN_SEATS} paths, programs and pictures at a time");
            return Err(Error::new(Code::TooMany, text));
        }
        state.seats.insert(user.to_owned(), own + 1);
        Ok(Seat { shared: self.0.clone(), user: user.to_owned(), memory: 0 })
    }

    /// Does a piece of work for a person in turns, beside the threads that serve requests. The work ends when this is dropped. The
    /// seat comes with the result: its memory counts until it is dropped.
    pub(crate) async fn run<T: Send + 'static>(
        &self,
        user: &str,
        work: impl FnOnce(&mut Work) -> Result<T, Error> + Send + 'static,
    ) -> Result<(T, Seat), Error> {
        let mut place = Work::new(self.seat(user)?);
        let waits = Waits { is_gone: place.is_gone.clone(), shared: self.0.clone() };
        let done = spawn_blocking(move || {
            place.wait_for_turn()?;
            let result = work(&mut place)?;
            place.end(result)
        });
        let done = done.await.map_err(|_| Error::new(Code::Refused, "the work has failed"));
        drop(waits);
        done?
    }
}

impl Room {
    fn lock(&self) -> MutexGuard<'_, PoolState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Ends the work when nobody waits for it any more.
struct Waits {
    is_gone: Arc<AtomicBool>,
    shared: Arc<Room>,
}

impl Drop for Waits {
    fn drop(&mut self) {
        let state = self.shared.lock();
        self.is_gone.store(true, Relaxed);
        drop(state);
        self.shared.changed.notify_all();
    }
}

/// A seat in the pool, with the memory that it takes.
pub(crate) struct Seat {
    shared: Arc<Room>,
    user: String,
    memory: usize,
}

impl Seat {
    /// Notes how much memory it takes now.
    pub(crate) fn take(&mut self, bytes: usize) -> Result<(), Limit> {
        let mut state = self.shared.lock();
        let others = state.memory - self.memory;
        if bytes > OWN_MEMORY.max(self.memory) && others.saturating_add(bytes) > MAX_MEMORY {
            return Err(Limit::Memory);
        }
        state.memory = others.saturating_add(bytes);
        drop(state);
        self.memory = bytes;
        Ok(())
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.memory -= self.memory;
        let left = state.seats.get(&self.user).map_or(0, |n| n - 1);
        if left == 0 {
            state.seats.remove(&self.user);
        } else {
            state.seats.insert(self.user.clone(), left);
        }
    }
}

/// A piece of work in progress.
pub(crate) struct Work {
    /// Given back with the result.
    seat: Option<Seat>,
    shared: Arc<Room>,
    number: u64,
    is_gone: Arc<AtomicBool>,
    /// Time that it has taken in earlier turns, and the begin of this one.
    taken: Duration,
    since: Option<Duration>,
}

impl Work {
    fn new(seat: Seat) -> Self {
        let shared = seat.shared.clone();
        let mut state = shared.lock();
        state.numbers += 1;
        let number = state.numbers;
        drop(state);
        let (seat, taken) = (Some(seat), Duration::ZERO);
        Self { seat, shared, number, is_gone: Arc::default(), taken, since: None }
    }

    /// Looks whether the work may go on with so many bytes, and lets others have their turn.
    pub(crate) fn look(&mut self, bytes: usize) -> Result<(), Limit> {
        if self.is_gone.load(Relaxed) {
            return Err(Limit::Gone);
        }
        self.seat.as_mut().map_or(Ok(()), |seat| seat.take(bytes))?;
        let now = (self.shared.clock)();
        let turn = self.since.map_or(Duration::ZERO, |since| now.saturating_sub(since));
        if self.taken + turn > MAX_TIME {
            return Err(Limit::Time);
        }
        if turn > TURN && !self.shared.lock().line.is_empty() {
            self.give_turn();
            self.wait_for_turn()?;
        }
        Ok(())
    }

    /// Does a part that makes no looks while others have their turns. Its size must be bounded.
    pub(crate) fn apart<T>(&mut self, part: impl FnOnce() -> T) -> Result<T, Limit> {
        self.give_turn();
        let done = part();
        self.wait_for_turn()?;
        Ok(done)
    }

    fn wait_for_turn(&mut self) -> Result<(), Limit> {
        let mut state = self.shared.lock();
        state.line.push_back(self.number);
        loop {
            if self.is_gone.load(Relaxed) {
                state.line.retain(|number| *number != self.number);
                drop(state);
                self.shared.changed.notify_all();
                return Err(Limit::Gone);
            }
            if state.turn.is_none() && state.line.front() == Some(&self.number) {
                state.line.pop_front();
                state.turn = Some(self.number);
                self.since = Some((self.shared.clock)());
                return Ok(());
            }
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn give_turn(&mut self) {
        let Some(since) = self.since.take() else { return };
        self.taken += (self.shared.clock)().saturating_sub(since);
        self.shared.lock().turn = None;
        self.shared.changed.notify_all();
    }

    /// Ends the work; returns the result with the seat.
    fn end<T>(mut self, result: T) -> Result<(T, Seat), Error> {
        self.give_turn();
        let seat = self.seat.take().ok_or(Limit::Gone)?;
        Ok((result, seat))
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        self.give_turn();
    }
}

#[cfg(test)]
mod tests;

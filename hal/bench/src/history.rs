//! Histories of calls that overlap in time, and the search for an order of them in which each call does what a sequential model
//! says (linearizability).
//!
//! ```
//! use hal_bench::history::{Event, Right, explain};
//! # use hal_bench::history::RightCall::{Take, Give, Use};
//! // Two clients take a right; the second call began while the first gave it back.
//! let history = [
//!     Event { call: Take(1), begun: 0, ended: Some(1) },
//!     Event { call: Give(1, true), begun: 2, ended: Some(5) },
//!     Event { call: Take(2), begun: 3, ended: Some(4) },
//! ];
//! assert!(explain(&Right, &history).is_ok());
//! // Afterwards the first client has it no more.
//! let late = Event { call: Use(1, true), begun: 6, ended: Some(7) };
//! assert!(explain(&Right, &[&history[..], &[late]].concat()).is_err());
//! ```

use std::collections::BTreeSet;

/// A call with its answer.
#[derive(Clone, Debug)]
pub struct Event<C> {
    /// The call, and what was answered.
    pub call: C,
    /// Moment before the call.
    pub begun: u64,
    /// Moment after the answer. `None`: the caller has no answer, so the call may have had its effect at any time since, or never.
    pub ended: Option<u64>,
}

/// A sequential model.
pub trait Model {
    /// A call with its answer.
    type Call;
    /// State that the calls before have left.
    type State: Clone + Default + Ord;

    /// Returns the state after a call; `None` if the call is not answered so in this state.
    fn step(&self, state: &Self::State, call: &Self::Call) -> Option<Self::State>;
}

/// Calls that no order explains, by their places in the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unexplained {
    /// The longest order that was found.
    pub order: Vec<usize>,
    /// Calls that cannot follow it, one of which comes next.
    pub stuck: Vec<usize>,
}

/// Number of calls after the first open one among which the next is looked for.
const WINDOW: usize = 128;

/// Returns the places of all calls in an order that explains them. Calls without an answer may be missing.
///
/// # Errors
/// There is no such order.
///
/// # Panics
/// More than 128 calls overlap.
pub fn explain<M: Model>(model: &M, history: &[Event<M::Call>]) -> Result<Vec<usize>, Unexplained> {
    let mut sorted: Vec<usize> = (0..history.len()).collect();
    sorted.sort_by_key(|at| history.get(*at).map(|event| event.begun));
    let empty = Unexplained { order: Vec::new(), stuck: Vec::new() };
    let mut search =
        Search { model, history, sorted, seen: BTreeSet::new(), order: Vec::new(), best: empty };
    match search.follow(Place { first: 0, done: 0 }, &M::State::default()) {
        true => Ok(search.order),
        false => Err(search.best),
    }
}

/// The calls that are done: all before `first`, and of those after it the ones of the bits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    first: usize,
    done: u128,
}

impl Place {
    fn has(self, at: usize) -> bool {
        at < self.first || at - self.first < WINDOW && self.done >> (at - self.first) & 1 != 0
    }

    fn with(mut self, at: usize) -> Self {
        assert!(at - self.first < WINDOW, "more than {WINDOW} calls overlap");
        self.done |= 1 << (at - self.first);
        while self.done & 1 != 0 {
            (self.first, self.done) = (self.first + 1, self.done >> 1);
        }
        self
    }
}

struct Search<'h, M: Model> {
    model: &'h M,
    history: &'h [Event<M::Call>],
    /// Places in the history, by the begin of the calls.
    sorted: Vec<usize>,
    seen: BTreeSet<(Place, M::State)>,
    order: Vec<usize>,
    best: Unexplained,
}

impl<M: Model> Search<'_, M> {
    fn event(&self, at: usize) -> Option<(usize, &Event<M::Call>)> {
        let place = *self.sorted.get(at)?;
        Some((place, self.history.get(place)?))
    }

    fn follow(&mut self, place: Place, state: &M::State) -> bool {
        if place.first == self.sorted.len() {
            return true;
        }
        if !self.seen.insert((place, state.clone())) {
            return false;
        }
        // Who began after the end of an open call comes after it.
        let (mut soonest, mut next) = (u64::MAX, Vec::new());
        for at in place.first.. {
            let Some((_, event)) = self.event(at) else { break };
            if soonest < event.begun {
                break;
            }
            if !place.has(at) {
                soonest = soonest.min(event.ended.unwrap_or(u64::MAX));
                next.push(at);
            }
        }
        let mut stuck = Vec::new();
        for at in next {
            let Some((number, event)) = self.event(at) else { continue };
            if soonest < event.begun {
                continue;
            }
            let has_no_answer = event.ended.is_none();
            if let Some(after) = self.model.step(state, &event.call) {
                self.order.push(number);
                if self.follow(place.with(at), &after) {
                    return true;
                }
                self.order.pop();
            } else {
                stuck.push(number);
            }
            if has_no_answer && at == place.first && self.follow(place.with(at), state) {
                return true;
            }
        }
        if self.best.order.len() <= self.order.len() {
            self.best = Unexplained { order: self.order.clone(), stuck };
        }
        false
    }
}

/// A right that nobody has, or one client: each time that somebody takes it, it has another number.
#[derive(Clone, Copy, Debug)]
pub struct Right;

/// A call that concerns a right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RightCall {
    /// Taken with this number.
    Take(u64),
    /// Not given, because somebody has it.
    NotTaken,
    /// The holder of the first number handed it over under the second.
    Hand(u64, u64),
    /// The holder of this number gave it back, or was refused because it is not theirs.
    Give(u64, bool),
    /// Something was done that needs it under this number, or refused for want of it.
    Use(u64, bool),
    /// The holder of this number has lost it, unless it is theirs no more.
    Lose(u64),
    /// Somebody looked, and saw this number; 0 is nobody's.
    Seen(u64),
    /// A new begin of the keeper: nobody has it.
    Restart,
}

impl Model for Right {
    type Call = RightCall;
    /// Number of who has it; 0 is nobody.
    type State = u64;

    fn step(&self, state: &u64, call: &RightCall) -> Option<u64> {
        let has = |number: u64| number != 0 && *state == number;
        match *call {
            RightCall::Take(number) => (*state == 0).then_some(number),
            RightCall::NotTaken => (*state != 0).then_some(*state),
            RightCall::Hand(from, to) => has(from).then_some(to),
            RightCall::Give(number, true) => has(number).then_some(0),
            RightCall::Use(number, true) => has(number).then_some(*state),
            RightCall::Give(number, false) | RightCall::Use(number, false) => {
                (!has(number)).then_some(*state)
            }
            RightCall::Lose(number) => Some(if has(number) { 0 } else { *state }),
            RightCall::Seen(number) => (*state == number).then_some(*state),
            RightCall::Restart => Some(0),
        }
    }
}

#[cfg(test)]
mod tests {
    //! Histories that must be explained, and those with a fault, which must not.

    use super::{
        Event, Right,
        RightCall::{self, Give, Hand, Lose, NotTaken, Restart, Seen, Take, Use},
        explain,
    };

    /// Returns a history of calls, each with its begin and its end; 0 is no end.
    fn history(calls: &[(RightCall, u64, u64)]) -> Vec<Event<RightCall>> {
        let event = |(call, begun, ended): &(RightCall, u64, u64)| Event {
            call: *call,
            begun: *begun,
            ended: (*ended != 0).then_some(*ended),
        };
        calls.iter().map(event).collect()
    }

    #[test]
    fn histories_of_a_right_are_explained() {
        for calls in [
            &[(Take(1), 0, 1), (Use(1, true), 2, 3), (Give(1, true), 4, 5), (Take(2), 6, 7)][..],
            // Calls that overlap, in the other order of their ends.
            &[(Take(1), 0, 1), (Take(2), 2, 3), (Give(1, true), 2, 9), (Use(1, true), 2, 4)],
            &[(Take(1), 0, 1), (NotTaken, 0, 1), (Use(7, false), 2, 3), (Seen(1), 4, 5)],
            // Without an answer it may have been given, or not.
            &[(Take(1), 0, 0), (Take(2), 1, 2)],
            &[(Take(1), 0, 0), (NotTaken, 1, 2), (Lose(1), 3, 4), (Take(2), 5, 6)],
            // The loss came before the command, or behind it.
            &[(Take(1), 0, 1), (Lose(1), 2, 6), (Use(1, true), 3, 4), (Use(1, false), 5, 7)],
            &[(Take(1), 0, 1), (Hand(1, 2), 2, 3), (Lose(1), 4, 5), (Use(2, true), 6, 7)],
            &[(Take(1), 0, 1), (Restart, 2, 3), (Seen(0), 4, 5), (Take(2), 6, 7)],
        ] {
            let events = history(calls);
            let order = explain(&Right, &events).unwrap_or_else(|why| panic!("{calls:?}: {why:?}"));
            assert!(order.len() + 1 >= events.len(), "{calls:?}: {order:?}");
        }
    }

    #[test]
    fn histories_with_a_fault_are_not() {
        for (fault, calls) in [
            ("two holders", &[(Take(1), 0, 1), (Take(2), 2, 3)][..]),
            (
                "two holders, of whom one has no answer to the end",
                &[
                    (Take(1), 0, 1),
                    (Use(1, true), 2, 3),
                    (Take(2), 4, 5),
                    (Use(1, true), 6, 7),
                    (Give(1, true), 8, 9),
                ],
            ),
            (
                "a command after a takeover",
                &[(Take(1), 0, 1), (Hand(1, 2), 2, 3), (Use(1, true), 4, 5)],
            ),
            (
                "a command after the end",
                &[(Take(1), 0, 1), (Give(1, true), 2, 3), (Use(1, true), 4, 5)],
            ),
            ("a command that nobody may give", &[(Use(1, true), 0, 1), (Take(1), 2, 3)]),
            ("a command of the holder that is refused", &[(Take(1), 0, 1), (Use(1, false), 2, 3)]),
            ("a lost release", &[(Take(1), 0, 1), (Give(1, true), 2, 3), (NotTaken, 4, 5)]),
            ("an expiry that is lost", &[(Take(1), 0, 1), (Lose(1), 2, 3), (Use(1, true), 4, 5)]),
            ("an expiry that comes before its time", &[(Take(1), 0, 1), (Seen(0), 2, 3)]),
            (
                "a right that outlives a restart",
                &[(Take(1), 0, 1), (Restart, 2, 3), (Use(1, true), 4, 5)],
            ),
            ("a holder after a restart", &[(Take(1), 0, 1), (Restart, 2, 3), (Seen(1), 4, 5)]),
            (
                "a call without an answer that had two effects",
                &[(Take(1), 0, 0), (Give(1, true), 1, 2), (NotTaken, 3, 4)],
            ),
        ] {
            let why = explain(&Right, &history(calls)).expect_err(fault);
            assert!(!why.stuck.is_empty(), "{fault}: {why:?}");
        }
    }

    #[test]
    fn a_long_history_takes_no_long_search() {
        // Four clients whose calls always overlap: the last of many is the fault.
        let mut calls = Vec::new();
        for n in 0..200_u64 {
            let at = 10 * n;
            calls.push((Take(n + 1), at, at + 12));
            calls.push((Use(n + 1, true), at + 1, at + 12));
            calls.push((NotTaken, at + 1, at + 12));
            calls.push((Give(n + 1, true), at + 2, at + 12));
        }
        assert!(explain(&Right, &history(&calls)).is_ok());
        calls.push((Use(5, true), 2020, 2030));
        assert!(explain(&Right, &history(&calls)).is_err());
    }
}

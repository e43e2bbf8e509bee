//! An operator who takes the lease, keeps it with beats, commands the machine, and is not always told what has become of it.

use hal_bench::{Random, history::RightCall};
use std::collections::VecDeque;

/// Time between two beats in milliseconds.
const BEAT_MS: u32 = 20;

/// Request of an operator to the plugin. Leases have their numbers in the history.
#[derive(Clone, Copy, Debug)]
pub(super) enum Request {
    /// The lease.
    Take,
    /// A new lease for the one that the operator has.
    Hand(u64),
    /// The end of the lease.
    Give(u64),
    /// A command of the plugin that needs it.
    Use(u64, &'static str),
    /// The number of who has it.
    Look,
    /// A pulse that comes back.
    Beat(u64, u32),
}

/// A request or an answer on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Message {
    pub(super) request: Request,
    /// Number of the call; beats are none.
    pub(super) call: Option<usize>,
    pub(super) answer: Option<RightCall>,
}

/// A direction of a connection: messages arrive in their order, late, or never.
#[derive(Debug, Default)]
pub(super) struct Way {
    messages: VecDeque<(u32, Message)>,
    held_until: u32,
}

impl Way {
    pub(super) fn send(&mut self, at: u32, message: Message) {
        let behind = self.messages.back().map_or(0, |(at, _)| *at);
        self.messages.push_back((at.max(behind), message));
    }

    /// Lets nothing arrive until then: what is sent meanwhile comes afterwards.
    pub(super) fn hold(&mut self, until: u32) {
        self.held_until = until;
    }

    pub(super) fn due(&mut self, now: u32) -> Option<Message> {
        let is_due = |(at, _): &(u32, Message)| self.held_until.max(*at) <= now;
        let due = self.messages.front().is_some_and(is_due);
        due.then(|| self.messages.pop_front().unwrap().1)
    }
}

/// The operator.
#[derive(Debug, Default)]
pub(super) struct Operator {
    pub(super) up: Way,
    pub(super) down: Way,
    /// Time until which nothing is done: a computer that sleeps.
    pub(super) stands_until: u32,
    /// The lease that the operator has, as far as known, and the last one.
    lease: Option<u64>,
    last: Option<u64>,
    waits: bool,
    next_beat: u32,
}

impl Operator {
    /// Cuts the connection: what is on its way is lost. The operator connects again, and still knows a lease.
    pub(super) fn cut(&mut self) {
        let Self { lease, last, .. } = *self;
        *self = Self { lease, last, ..Self::default() };
    }

    /// Takes an answer.
    pub(super) fn answered(&mut self, message: Message) {
        self.waits &= message.call.is_none();
        match message.answer {
            Some(RightCall::Take(right) | RightCall::Hand(_, right)) => {
                (self.lease, self.last) = (Some(right), Some(right));
            }
            Some(RightCall::Give(right, _) | RightCall::Use(right, false)) => {
                self.lease = self.lease.filter(|lease| *lease != right);
            }
            _ => {}
        }
    }

    /// Returns the beat that is due: the last pulse, on a link without a delay in this direction.
    pub(super) fn beat(&mut self, now: u32, pulse: u32) -> Option<Request> {
        let lease = self.lease.filter(|_| self.next_beat <= now)?;
        self.next_beat = now + BEAT_MS;
        Some(Request::Beat(lease, pulse))
    }

    /// Returns the next call, if none waits for its answer.
    pub(super) fn next(&mut self, random: &mut Random) -> Option<Request> {
        if self.waits || random.below(10) != 0 {
            return None;
        }
        self.waits = true;
        let command =
            random.pick(&["remote.start", "remote.refused", "remote.tool-changed", "remote.beat"]);
        Some(match (self.lease, self.last, random.below(20)) {
            (_, _, 0..2) => Request::Look,
            (Some(lease), _, 2..4) => Request::Give(lease),
            (Some(lease), _, 4..6) => Request::Hand(lease),
            (Some(lease), ..) => Request::Use(lease, command),
            // A program that does not know of the loss.
            (None, Some(last), 2..6) => Request::Use(last, command),
            (None, Some(last), 6) => Request::Give(last),
            (None, ..) => Request::Take,
        })
    }
}

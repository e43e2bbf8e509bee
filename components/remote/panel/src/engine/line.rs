//! Work that waits for the engine: stops, which go before everything else, and requests in their order.

use super::{Ending, Stopped, gone};
use crate::error::{Code, Error};
use hal_protocol::{Reply, Request};
use std::{collections::VecDeque, time::Duration};
use tokio::{sync::oneshot, time::Instant};

/// Number of requests that wait for the engine.
pub(super) const MAX_WAITING: usize = 256;
/// Number of further places, for the ends of jogs.
pub(super) const MAX_ENDS: usize = 64;
/// Number of askers of a stop from which on those that have gone are left out.
const MAX_ASKED: usize = 64;
/// Shortest time between two stops of one kind: those that come faster are one.
pub(super) const SPACING: Duration = Duration::from_millis(20);

/// The answer to a request.
pub(super) type PendingReply = oneshot::Receiver<Result<Reply, Error>>;

/// A request that waits.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) request: Request,
    /// Number of stops after which it is refused.
    unless: Option<u64>,
    pub(super) answer: oneshot::Sender<Result<Reply, Error>>,
}

/// A kind of stop.
#[derive(Debug)]
struct StopKind {
    ending: Ending,
    /// Answers that are awaited; none if nobody has asked for it since it was sent.
    asked: Vec<oneshot::Sender<Stopped>>,
    sent: Option<Instant>,
}

impl StopKind {
    /// Returns how long it still waits, if somebody has asked for it. The first one goes at once.
    fn rest(&self, now: Instant) -> Option<Duration> {
        let since = self.sent.map_or(SPACING, |sent| now.saturating_duration_since(sent));
        (!self.asked.is_empty()).then(|| SPACING.saturating_sub(since))
    }
}

/// The line.
#[derive(Debug)]
pub(super) struct RequestLine {
    jobs: VecDeque<Job>,
    kinds: [StopKind; 6],
    /// Number of stops so far.
    stops: u64,
    has_ended: bool,
}

impl Default for RequestLine {
    fn default() -> Self {
        let kinds = Ending::ALL.map(|ending| StopKind { ending, asked: Vec::new(), sent: None });
        Self { jobs: VecDeque::new(), kinds, stops: 0, has_ended: false }
    }
}

/// Next thing that the thread does.
#[derive(Debug)]
pub(super) enum Next {
    Stop(Ending, Vec<oneshot::Sender<Stopped>>),
    Job(Job),
    /// A stop has come after this request was given.
    Refuse(Job),
    /// Nothing, for so long if a stop is asked for; else until something joins.
    Wait(Option<Duration>),
    End,
}

impl RequestLine {
    pub(super) const fn stops(&self) -> u64 {
        self.stops
    }

    /// Ends the line: who waits gets no answer.
    pub(super) fn end(&mut self) {
        self.has_ended = true;
        self.jobs.clear();
        self.kinds.iter_mut().for_each(|kind| kind.asked.clear());
    }

    /// Adds a request, which is refused if there are more stops than these when its turn comes.
    pub(super) fn join(
        &mut self,
        request: Request,
        unless: Option<u64>,
    ) -> Result<PendingReply, Error> {
        if unless.is_some_and(|before| before != self.stops) {
            return Err(Error::new(Code::Conflict, super::STOPPED));
        }
        self.push(request, unless, MAX_WAITING)
    }

    /// Adds a request that ends jogs.
    pub(super) fn join_end(&mut self, request: Request) -> Result<PendingReply, Error> {
        self.push(request, None, MAX_WAITING + MAX_ENDS)
    }

    fn push(
        &mut self,
        request: Request,
        unless: Option<u64>,
        most: usize,
    ) -> Result<PendingReply, Error> {
        if self.has_ended {
            return Err(gone());
        }
        if self.jobs.len() >= most {
            return Err(Error::new(Code::TooMany, "too many requests wait for the engine"));
        }
        let (answer, reply) = oneshot::channel();
        self.jobs.push_back(Job { request, unless, answer });
        Ok(reply)
    }

    /// Asks for a stop.
    pub(super) fn stop(&mut self, ending: Ending) -> Result<oneshot::Receiver<Stopped>, Error> {
        if self.has_ended {
            return Err(gone());
        }
        self.stops += 1;
        let (answer, stopped) = oneshot::channel();
        if let Some(kind) = self.kinds.iter_mut().find(|kind| kind.ending == ending) {
            // Who does not wait any more needs no place, but the stop itself does.
            if kind.asked.len() >= MAX_ASKED {
                kind.asked.retain(|asked| !asked.is_closed());
            }
            kind.asked.push(answer);
        }
        Ok(stopped)
    }

    /// Takes what comes next.
    pub(super) fn next(&mut self, now: Instant) -> Next {
        if self.has_ended {
            return Next::End;
        }
        let due = self.kinds.iter_mut().find(|kind| kind.rest(now).is_some_and(|r| r.is_zero()));
        if let Some(kind) = due {
            kind.sent = Some(now);
            return Next::Stop(kind.ending, core::mem::take(&mut kind.asked));
        }
        let rest = self.kinds.iter().filter_map(|kind| kind.rest(now)).min();
        let Some(job) = self.jobs.pop_front() else { return Next::Wait(rest) };
        match (job.unless, rest) {
            (Some(before), _) if before != self.stops => Next::Refuse(job),
            // It was given after a stop that is still to be sent.
            (Some(_), Some(_)) => {
                self.jobs.push_front(job);
                Next::Wait(rest)
            }
            _ => Next::Job(job),
        }
    }
}

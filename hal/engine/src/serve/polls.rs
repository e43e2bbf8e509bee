//! Waits of clients: their ends, and how long the virtual clock waits for a client.

use crate::{
    Engine, Error,
    graph::{Graph, Ix},
    os,
    serve::client::{Client, WaitState},
    serve::hold::Hold,
    serve::server::Server,
    serve::session::put_writes,
};
use hal_protocol::{Failure, Reply, TicketInfo, Value};

/// Shortest and longest period of a program's polls, in nanoseconds; 0 means that it never polls.
const PERIODS: core::ops::RangeInclusive<u64> = 1_000..=1_000_000_000_000;
/// Returns the period of a program's polls if it is within limits: a program that polls too rarely
/// or too often would hold the virtual clock.
pub(crate) fn period(poll_ns: u64) -> Result<i64, Error> {
    let usable = poll_ns == 0 || PERIODS.contains(&poll_ns);
    i64::try_from(poll_ns).ok().filter(|_| usable).ok_or_else(|| {
        let (shortest, longest) = (PERIODS.start(), PERIODS.end());
        let why = format!(
            "a program cannot poll every {poll_ns} ns; expected {shortest} to {longest} ns, or 0 \
             for one that never polls"
        );
        Error::Protocol { why: why.into() }
    })
}

/// Returns whether a client waits for the end of a command.
pub(crate) fn waits_for_ticket(engine: &Engine) -> bool {
    let clients = engine.clients.server.iter().flat_map(|s| &s.clients);
    clients.into_iter().any(|c| matches!(c.waits, WaitState::Ticket(_)))
}

/// Returns the time of the next poll that is due, in machine time.
pub(crate) fn next_poll(engine: &Engine) -> i64 {
    let clients = engine.clients.server.iter().flat_map(|s| &s.clients);
    let times = clients.filter_map(|c| match c.waits {
        WaitState::Poll(t) | WaitState::Time(t) => Some(t),
        // The program must have polled by then.
        WaitState::No => c.poll_due,
        WaitState::Wall(_) | WaitState::Ticket(_) => None,
    });
    times.min().unwrap_or(i64::MAX)
}

/// Returns whether a program that the clock waits for is overdue with its poll. A program that is
/// stopped (SIGSTOP, a debugger) or holds the clock for too long is not waited for again until it polls.
pub(crate) fn owes_poll(engine: &mut Engine) -> bool {
    let (now, wall) = (engine.runtime.now(), os::monotonic_ns());
    let patience_ns = engine.clients.patience_ns;
    let (mut poll_due, mut late) = (false, Vec::new());
    for c in engine.clients.server.iter_mut().flat_map(|s| &mut s.clients) {
        if c.waits != WaitState::No || c.poll_due.is_none_or(|t| t > now) {
            continue;
        }
        let is_late = c.hold.outlasts(patience_ns, wall);
        // A process that is stopped polls when a person lets it: the clock does not wait for that.
        let is_stopped = c.hold.looks() && os::process::is_stopped(c.pid);
        if is_late || is_stopped {
            (c.poll_due, c.hold) = (None, Hold::NONE);
            late.push((c.component, c.pid, is_stopped));
        } else {
            poll_due = true;
        }
    }
    for (component, pid, is_stopped) in late {
        let name =
            component.and_then(|ix| engine.model.graph().component(ix)).map(|c| c.name.clone());
        let name = name.as_ref().map_or("?", |name| name.as_str());
        let what = if is_stopped {
            "is stopped".to_owned()
        } else {
            format!("has not polled for {}", seconds(patience_ns))
        };
        engine.notice(format!(
            "program '{name}' (process {pid}) {what}: the virtual clock waits for it again when it \
             polls"
        ));
    }
    poll_due
}

/// Returns whether no program still has a poll due at this machine time or before.
pub(crate) fn has_polled(engine: &mut Engine) -> bool {
    let now = engine.runtime.now();
    let clients = engine.clients.server.iter().flat_map(|s| &s.clients);
    let is_due = |c: &Client| matches!(c.waits, WaitState::Poll(t) if t <= now);
    let has_polled = !clients.into_iter().any(is_due) && !owes_poll(engine);
    if has_polled {
        engine.take_pages();
    }
    has_polled
}

/// Returns the machine time up to which clients' waits let the virtual clock move.
pub(crate) fn clients_target(server: &Server) -> i64 {
    let targets = server.clients.iter().filter_map(|c| match c.waits {
        WaitState::Time(t) => Some(t),
        WaitState::Ticket(_) => Some(i64::MAX),
        WaitState::Wall(_) if c.advances_clock => Some(i64::MAX),
        _ => None,
    });
    targets.max().unwrap_or(i64::MIN)
}

/// Returns the machine time at which the next pending poll is to be answered.
pub(crate) fn next_poll_of(server: &Server) -> i64 {
    let times = server.clients.iter().filter_map(|c| match c.waits {
        WaitState::Poll(t) => Some(t),
        _ => None,
    });
    times.min().unwrap_or(i64::MAX)
}

/// Answers a client whose wait is over.
pub(crate) fn settle(engine: &mut Engine, c: &mut Client) {
    let now = engine.runtime.now();
    let reply = match c.waits {
        WaitState::Wall(t) if os::monotonic_ns() >= t => Ok(Reply::Done),
        WaitState::Time(t) if now >= t => Ok(Reply::Done),
        WaitState::Poll(t) if now >= t => {
            put_writes(engine, c);
            c.poll_due = Some(now.saturating_add(c.poll_after()));
            if c.page.is_some() {
                c.take_page(engine);
                c.publish_page(engine);
                Ok(Reply::Done)
            } else {
                Ok(values(engine, c))
            }
        }
        WaitState::Ticket(id) => match engine.result(id) {
            Ok(TicketInfo::Pending) if engine.runtime.fault().is_none() => return,
            other => other.map(Reply::Ticket).map_err(Failure::from),
        },
        WaitState::No | WaitState::Wall(_) | WaitState::Time(_) | WaitState::Poll(_) => return,
    };
    c.waits = WaitState::No;
    c.advances_clock = false;
    c.answer(reply);
}

fn values(engine: &Engine, c: &Client) -> Reply {
    let value = |ix: &Ix| engine.model.graph().item(*ix).map(|i| Graph::value(i.ty, i.bits()));
    let values = c.pins.iter().map(|ix| value(ix).unwrap_or(Value::Bit(false))).collect();
    Reply::Values { time: u64::try_from(engine.runtime.now()).unwrap_or(0), values }
}

impl Engine {
    /// Forgets programs that have ended, and reports those that a signal ended.
    pub(crate) fn forget_ended_programs(&mut self) {
        let mut killed = Vec::new();
        let awaited = self.clients.waits_for;
        let before = self.clients.programs.len();
        self.clients.programs.retain(|p| {
            let life = os::life(p.pid);
            if let os::Life::Killed(signal) = life {
                let signal = os::process::signal_name(signal);
                killed.push(format!("program '{}' was ended by {signal}", p.name));
            }
            let runs = life == os::Life::Runs;
            self.clients.has_awaited |= !runs && awaited == Some(p.pid);
            runs
        });
        if self.clients.programs.len() != before {
            self.clients.publish_programs(self.runtime.instance());
        }
        self.notices(killed);
    }

    /// Returns whether the virtual clock must wait for a program, or for a ring that a program
    /// reads or writes.
    pub(crate) fn held_back(&mut self) -> bool {
        let now = os::monotonic_ns();
        let starting = self.clients.programs.iter().any(|p| self.clients.is_starting(p, now));
        // Evaluate every condition: each measures for how long it has held the clock.
        let for_samples = self.held_by_samples(now);
        let for_polls = owes_poll(self);
        let for_rings = self.clients.script_waits && self.held_by_rings(now);
        starting
            || self.clients.has_awaited
            || for_samples
            || for_polls
            || for_rings
            || self
                .clients
                .waits_for
                .is_some_and(|pid| self.model.rings().values().any(|r| r.is_enough_for(pid)))
    }

    /// Returns whether a reader or the recorder has left no room for data that must not be lost.
    fn held_by_samples(&mut self, now: i64) -> bool {
        if self.observers.probes().have_room() {
            return false;
        }
        let patience_ns = self.clients.patience_ns;
        for id in self.observers.unread_samples(|hold| hold.outlasts(patience_ns, now)) {
            self.observers.lose(id);
            self.notice(format!(
                "sample {id} has not been read for {}: the virtual clock waits for its reader no \
                 longer, and samples without room are lost",
                seconds(patience_ns)
            ));
        }
        !self.observers.probes().have_room()
    }

    /// Returns whether the virtual clock would overrun a stream while a script waits.
    fn held_by_rings(&mut self, now: i64) -> bool {
        let (patience_ns, mut held, mut late) = (self.clients.patience_ns, false, Vec::new());
        for (name, ring) in self.model.rings_mut() {
            if ring.holds_back(patience_ns, now, || late.push(name.clone())) {
                held = true;
            }
        }
        for name in late {
            self.notice(format!(
                "stream '{}' has been empty for {}: the virtual clock waits for its writer again \
                 when it has written",
                name.as_str(),
                seconds(patience_ns)
            ));
        }
        held
    }
}

/// Formats a time in seconds, for messages.
fn seconds(ns: i64) -> String {
    format!("{} s", ns as f64 / 1e9)
}

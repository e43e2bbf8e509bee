//! The clients of an instance: connections, programs that a script has started, results of
//! commands, and the waits that let the virtual clock move.
//!
//! Only the files of this room see the fields.

use crate::{
    Error,
    ends::Instance,
    graph::{Graph, Ix},
    messages::join::filled,
    os,
    realtime::runtime::TIMEOUT_NS,
    serve::server::Server,
};
use hal_abi::{Ticket, TicketState};
use hal_protocol::TicketInfo;
use std::collections::BTreeMap;

/// Time that the virtual clock waits for one client, in nanoseconds of wall-clock time, unless
/// `HAL_PATIENCE_MS` sets another.
const DEFAULT_PATIENCE_NS: i64 = 10_000_000_000;
/// Time that the virtual clock waits for a program that starts, in nanoseconds of wall-clock time.
const START_NS: i64 = 1_000_000_000;
/// Largest number of results that are kept.
const RESULTS: usize = 1000;

/// A program that a script started.
#[derive(Debug)]
pub(crate) struct Program {
    pub(in crate::serve) pid: i32,
    pub(in crate::serve) name: String,
    pub(in crate::serve) since: i64,
    pub(in crate::serve) joined: bool,
}

/// A command in progress.
#[derive(Debug)]
struct Pending {
    owner: Ix,
    ticket: Box<Ticket>,
}

/// Clients of an instance.
#[derive(Debug)]
pub(crate) struct Clients {
    pub(in crate::serve) server: Option<Server>,
    pub(in crate::serve) programs: Vec<Program>,
    pub(in crate::serve) shutdown: bool,
    /// True while the script waits: a full ring then holds the clock back.
    pub(in crate::serve) script_waits: bool,
    /// The program whose end the script waits for.
    pub(in crate::serve) waits_for: Option<i32>,
    /// True once that program has ended: the wait is over, and the clock moves no further in it.
    pub(in crate::serve) has_awaited: bool,
    /// Longest time that the virtual clock waits for one client, in nanoseconds of wall-clock time.
    pub(in crate::serve) patience_ns: i64,
    /// Machine time up to which the virtual clock may move.
    pub(in crate::serve) target: i64,
    /// Machine time up to which waiting clients let the clock move.
    pub(in crate::serve) client_target: i64,
    pending: BTreeMap<u64, Pending>,
    finished: BTreeMap<u64, TicketInfo>,
    next_ticket: u64,
}

impl Clients {
    /// Creates a list without clients.
    pub(crate) fn new() -> Self {
        let asked = std::env::var("HAL_PATIENCE_MS").ok().and_then(|ms| ms.parse::<u32>().ok());
        Self {
            server: None,
            programs: Vec::new(),
            shutdown: false,
            script_waits: false,
            waits_for: None,
            has_awaited: false,
            patience_ns: asked.map_or(DEFAULT_PATIENCE_NS, |ms| i64::from(ms) * 1_000_000),
            target: 0,
            client_target: i64::MIN,
            pending: BTreeMap::new(),
            finished: BTreeMap::new(),
            next_ticket: 1,
        }
    }

    /// Returns whether the virtual clock waits for a program that has not joined: for a second; a program whose end the
    /// script waits for, as long as nobody is connected, because what it does depends on no machine time then.
    pub(in crate::serve) fn is_starting(&self, p: &Program, now: i64) -> bool {
        let is_apart = self.server.as_ref().is_none_or(|s| s.clients.is_empty());
        let patience = if is_apart && self.waits_for == Some(p.pid) {
            self.patience_ns.max(START_NS)
        } else {
            START_NS
        };
        !p.joined && now - p.since < patience
    }

    /// Serves the clients of a socket from now on.
    pub(crate) fn listen(&mut self, server: Server) {
        self.server = Some(server);
    }

    /// Closes the socket and all connections.
    pub(crate) fn close(&mut self) {
        self.server = None;
    }

    /// Returns whether a client has asked the instance to end.
    pub(crate) const fn is_shutdown(&self) -> bool {
        self.shutdown
    }

    /// Ends every program that a script has started: first kindly, then by force.
    pub(crate) fn end_programs(&mut self, instance: &Instance) {
        instance.control.be_patient();
        for p in &self.programs {
            os::end_process(p.pid, false);
        }
        let limit = os::monotonic_ns() + TIMEOUT_NS;
        while self.programs.iter().any(|p| os::alive(p.pid)) && os::monotonic_ns() < limit {
            if let Some(server) = &mut self.server {
                server.drop_clients();
            }
            os::sleep_until(os::monotonic_ns() + 2_000_000);
        }
        for p in &self.programs {
            if os::alive(p.pid) {
                os::end_process(p.pid, true);
            }
        }
        self.programs.clear();
        self.publish_programs(instance);
        instance.control.have_waited();
    }

    /// Publishes the list of running programs after it has changed.
    pub(in crate::serve) fn publish_programs(&self, instance: &Instance) {
        instance.set_programs(self.programs.iter().map(|p| p.pid).collect());
    }
}

/// Results of commands.
impl Clients {
    /// Returns a new number for the result of a command of `owner`.
    pub(crate) fn await_result(&mut self, owner: Ix, ticket: Box<Ticket>) -> u64 {
        let id = self.next_ticket;
        self.next_ticket += 1;
        self.pending.insert(id, Pending { owner, ticket });
        id
    }

    /// Returns the state of a command. The graph has the wiring of pins that its result names.
    pub(crate) fn result(&mut self, id: u64, graph: &Graph) -> Result<TicketInfo, Error> {
        if let Some(done) = self.finished.get(&id) {
            return Ok(done.clone());
        }
        let pending = self.pending.get(&id).ok_or(Error::NoTicket { id })?;
        let info = match pending.ticket.state() {
            TicketState::Pending => return Ok(TicketInfo::Pending),
            TicketState::Done => TicketInfo::Done,
            TicketState::Failed(why) => {
                let (numbers, count) = pending.ticket.numbers();
                let numbers = numbers.get(..count).unwrap_or_default();
                TicketInfo::Failed(graph.with_wiring(&filled(why, numbers)))
            }
        };
        self.pending.remove(&id);
        self.finished.insert(id, info.clone());
        while self.finished.len() > RESULTS {
            self.finished.pop_first();
        }
        Ok(info)
    }

    /// Ends the pending commands of a component.
    pub(crate) fn fail_tickets(&mut self, owner: Ix, why: &str) {
        let its = self.pending.iter().filter(|(_, p)| p.owner == owner).map(|(id, _)| *id);
        for id in its.collect::<Vec<_>>() {
            self.pending.remove(&id);
            self.finished.insert(id, TicketInfo::Failed(why.to_owned()));
        }
    }
}

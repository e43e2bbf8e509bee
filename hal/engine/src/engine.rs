//! An instance: its parts, and the loop that serves its clients.

use crate::{
    ClockKind, Error, Options,
    analyse::dry_run::Trial,
    change::apply::{Retired, TIMEOUT_NS},
    change::transaction::Transaction,
    ends::{self, Instance},
    graph::arena::Arena,
    graph::{Graph, Ix},
    load::loader::Loader,
    messages::join::Joiner,
    messages::mailbox::Voice,
    name::Name,
    observe::flight::Flight,
    observe::record::Recording,
    observe::ring::SharedRing,
    observe::sample::Sample,
    observe::watch::Probes,
    os,
    realtime::resources::Realtime,
    realtime::runners::{Runners, Scheduling},
    realtime::shared::Shared,
    realtime::task::Task,
    realtime::watchdog::Watchdog,
    serve::polls,
    serve::request::MAX_TIME_NS,
    serve::server::Server,
    sync::Arc,
};
use hal_abi::{Ticket, TicketState};
use hal_protocol::{Failure, FaultInfo, Lock, Offer, Patterns, StoppedRecording, TicketInfo};
use std::{
    collections::{BTreeMap, VecDeque},
    sync::Mutex,
};

/// The reason why [`Engine::serve`] returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// There are no threads (any more).
    NoThreads,
    /// A client requested the shutdown.
    Shutdown,
    /// A signal requested the shutdown.
    Signal,
    /// The requested time has passed.
    Time,
}

/// Numbers of pins and parameters.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) pins: u32,
    pub(crate) params: u32,
}

/// A program that a script started.
#[derive(Debug)]
pub(crate) struct Program {
    pub(crate) pid: i32,
    #[expect(dead_code, reason = "shown when an instance is inspected")]
    pub(crate) name: String,
    pub(crate) since: i64,
    pub(crate) joined: bool,
}

/// A command in progress.
#[derive(Debug)]
pub(crate) struct Pending {
    pub(crate) owner: Ix,
    pub(crate) ticket: Box<Ticket>,
}

/// A running instance.
#[derive(Debug)]
pub struct Engine {
    pub(crate) options: Options,
    pub(crate) graph: Graph,
    pub(crate) counts: Counts,
    pub(crate) loader: Loader,
    pub(crate) shared: Arc<Shared>,
    /// The data that a report of the end of the process uses.
    pub(crate) instance: Arc<Instance>,
    /// Longest wait for threads, in nanoseconds of wall-clock time.
    pub(crate) settle_ns: i64,
    pub(crate) runners: Runners,
    /// Present from the first `start` on.
    pub(crate) watchdog: Option<Watchdog>,
    pub(crate) realtime: Realtime,
    pub(crate) lock: Lock,
    pub(crate) next_component: u32,
    pub(crate) next_thread: u32,
    pub(crate) tasks: Vec<Task>,
    pub(crate) rings: BTreeMap<Name, SharedRing>,
    pub(crate) programs: Vec<Program>,
    /// Components that have been unloaded or are about to be; a stuck thread may still hold some of
    /// them.
    pub(crate) left: Vec<Ix>,
    pub(crate) tickets: BTreeMap<u64, Pending>,
    pub(crate) finished: BTreeMap<u64, TicketInfo>,
    pub(crate) next_ticket: u64,
    pub(crate) recording: Option<Recording>,
    /// The latest recording, if it could not be written and another `record` has not come yet.
    pub(crate) stopped_recording: Option<StoppedRecording>,
    /// True if a recording, or the file of an event, could not be written whole.
    pub(crate) unwritten: bool,
    pub(crate) flight: Option<Arc<Mutex<Flight>>>,
    pub(crate) probes: Probes,
    /// The samples, by the numbers of their probes.
    pub(crate) samples: BTreeMap<u64, Sample>,
    pub(crate) fault: Option<FaultInfo>,
    pub(crate) server: Option<Server>,
    pub(crate) shutdown: bool,
    /// True while the script waits: a full ring then holds the clock back.
    pub(crate) script_waits: bool,
    /// The program whose end the script waits for.
    pub(crate) waits_for: Option<i32>,
    /// Longest time that the virtual clock waits for one client, in nanoseconds of wall-clock time.
    pub(crate) patience_ns: i64,
    /// Machine time up to which the virtual clock may move.
    pub(crate) target: i64,
    /// Machine time up to which waiting clients let the clock move.
    pub(crate) client_target: i64,
    pub(crate) retired: Vec<Retired>,
    pub(crate) messages: VecDeque<String>,
    /// Number of older messages that were discarded.
    pub(crate) dropped_messages: u64,
    pub(crate) joiner: Joiner,
    /// Message counts of each component, by the component's number.
    pub(crate) voices: BTreeMap<u32, Arc<Voice>>,
    /// The component that was removed last: messages of it may still arrive.
    pub(crate) gone: Option<(u32, Name)>,
    pub(crate) ticks: (u64, i64),
    pub(crate) quiet: bool,
    /// Present in a trial, which touches nothing outside the engine.
    pub(crate) trial: Option<Trial>,
    pub(crate) staged: Transaction,
    /// The last field: everything else points into it.
    pub(crate) arena: Arena,
}

impl Engine {
    /// Creates an instance and takes its socket.
    ///
    /// # Errors
    /// Another instance of this name is running, or the system refuses.
    pub fn new(options: Options) -> Result<Self, Failure> {
        let server = Server::open(&options.place)?;
        let mut engine = Self::without_socket(options)?;
        engine.server = Some(server);
        engine.instance.attend();
        Ok(engine)
    }

    /// Creates an instance that no client can reach, for tests and benchmarks.
    ///
    /// # Errors
    /// The system refuses.
    pub fn without_socket(mut options: Options) -> Result<Self, Failure> {
        options.simulate |= options.clock == ClockKind::Virtual;
        let realtime = Realtime::find(&options)?;
        let shared = Shared::new(options.clock);
        let stuck_ns = options.realtime.stuck_ns.unwrap_or(0);
        shared.set_stuck_limit(i64::try_from(stuck_ns).unwrap_or(i64::MAX));
        let threads = (realtime.scheduling, realtime.cpu);
        let instance = Instance::new(shared.clone(), &options.place);
        Ok(Self {
            arena: Arena::new(realtime.scheduling == Scheduling::Fifo)?,
            graph: Graph::default(),
            counts: Counts::default(),
            loader: Loader::new(options.path.clone()),
            runners: Runners::new(shared.clone(), threads, options.realtime.idle_us),
            realtime,
            watchdog: None,
            lock: Lock::NONE,
            next_component: 1,
            next_thread: 1,
            tasks: Vec::new(),
            rings: BTreeMap::new(),
            programs: Vec::new(),
            left: Vec::new(),
            tickets: BTreeMap::new(),
            finished: BTreeMap::new(),
            next_ticket: 1,
            recording: None,
            stopped_recording: None,
            unwritten: false,
            flight: None,
            probes: Probes::default(),
            samples: BTreeMap::new(),
            fault: None,
            server: None,
            shutdown: false,
            script_waits: false,
            waits_for: None,
            patience_ns: polls::patience_ns(),
            target: 0,
            client_target: i64::MIN,
            retired: Vec::new(),
            messages: VecDeque::new(),
            dropped_messages: 0,
            joiner: Joiner::default(),
            voices: BTreeMap::new(),
            gone: None,
            ticks: (os::ticks(), os::monotonic_ns()),
            quiet: true,
            trial: None,
            staged: Transaction::default(),
            shared,
            instance,
            settle_ns: TIMEOUT_NS,
            options,
        })
    }

    /// Registers the components of a library that is linked into this program.
    pub fn add_static(&mut self, library: &'static hal_abi::Library) {
        self.loader.add_static(library);
    }

    /// Returns every component type that the plugins on the path offer, by name.
    pub fn catalogue(&mut self) -> Vec<Offer> {
        self.loader.catalogue(&Patterns::default())
    }

    /// Serves clients until an [`Ended`] condition holds; `for_ns` limits machine time.
    pub fn serve(&mut self, for_ns: Option<u64>) -> Ended {
        let limit = for_ns
            .map(|ns| self.shared.now().saturating_add(i64::try_from(ns).unwrap_or(i64::MAX)))
            .map(|limit| limit.min(MAX_TIME_NS));
        let before = self.target;
        let ended = loop {
            if self.shutdown {
                break Ended::Shutdown;
            }
            if ends::is_asked() {
                break Ended::Signal;
            }
            if limit.is_some_and(|l| self.shared.now() >= l) {
                break Ended::Time;
            }
            if self.graph.threads.is_empty() && limit.is_none() {
                break Ended::NoThreads;
            }
            self.target = match limit {
                Some(l) => l,
                None if self.options.hold => self.target,
                None => i64::MAX,
            };
            let left = limit.map_or(100, |l| (l - self.shared.now()) / 1_000_000 + 1);
            self.pump(i32::try_from(left).unwrap_or(100).min(100));
        };
        self.target = before.min(self.shared.now());
        ended
    }

    /// Returns whether a signal or a client has asked the instance to end (a script then stops).
    #[must_use]
    pub fn is_ending(&self) -> bool {
        self.instance.control.beat();
        self.shutdown || ends::is_asked()
    }

    /// Returns machine time in nanoseconds.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        self.shared.now()
    }

    /// Returns the state of a command.
    pub(crate) fn ticket(&mut self, id: u64) -> Result<TicketInfo, Error> {
        if let Some(done) = self.finished.get(&id) {
            return Ok(done.clone());
        }
        let pending = self.tickets.get(&id).ok_or(Error::NoTicket { id })?;
        let info = match pending.ticket.state() {
            TicketState::Pending => return Ok(TicketInfo::Pending),
            TicketState::Done => TicketInfo::Done,
            TicketState::Failed(why) => {
                let (numbers, count) = pending.ticket.numbers();
                let numbers = numbers.get(..count).unwrap_or_default();
                TicketInfo::Failed(self.with_wiring(&crate::messages::join::filled(why, numbers)))
            }
        };
        self.tickets.remove(&id);
        self.finished.insert(id, info.clone());
        while self.finished.len() > 1000 {
            self.finished.pop_first();
        }
        Ok(info)
    }

    /// Returns an error if a bit of `lock` is set in the instance's lock.
    pub(crate) const fn unlocked(&self, lock: Lock, what: &'static str) -> Result<(), Error> {
        if self.lock.0 & lock.0 == 0 { Ok(()) } else { Err(Error::Locked { what }) }
    }
}

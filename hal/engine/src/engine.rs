//! An instance: what it consists of, and what its control side does while it waits.

use crate::{
    ClockKind, Error, Options,
    arena::Arena,
    change::{Change, MOST_STORES},
    clock::{self, Runners, Scheduling},
    graph::{Graph, Ix},
    loader::Loader,
    name::Name,
    os,
    record::{Probe, Recording},
    ring::SharedRing,
    server::Server,
    shared::{Message, Shared},
    sync::{Arc, Ordering},
    task::Task,
    thread::{List, Thread},
};
use hal_abi::{Ticket, TicketState, level};
use hal_protocol::{Failure, FaultInfo, Lock, TicketInfo};
use std::collections::{BTreeMap, VecDeque};

/// How many instants of machine time are run between looks at the socket.
const SLICE: u32 = 4096;
/// How long a change may wait for a boundary, in wall time.
const PATIENCE_NS: i64 = 2_000_000_000;

/// Why [`Engine::serve`] returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// There is no thread (any more).
    NoThreads,
    /// A client asked for it.
    Shutdown,
    /// SIGINT, SIGTERM or SIGHUP came.
    Signal,
    /// The time is over.
    Time,
}

/// How many things there are.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) pins: u32,
    pub(crate) params: u32,
}

/// What threads may still be using.
#[derive(Debug)]
enum Retired {
    List(Arc<List>),
    Threads(Arc<Vec<Arc<Thread>>>),
    Probe(Arc<Probe>),
}

impl Retired {
    fn is_free(&self) -> bool {
        1 == match self {
            Self::List(a) => Arc::strong_count(a),
            Self::Threads(a) => Arc::strong_count(a),
            Self::Probe(a) => Arc::strong_count(a),
        }
    }
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

/// A command under way.
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
    pub(crate) runners: Runners,
    pub(crate) scheduling: String,
    pub(crate) lock: Lock,
    pub(crate) next_component: u32,
    pub(crate) next_thread: u32,
    pub(crate) tasks: Vec<Task>,
    pub(crate) rings: BTreeMap<Name, SharedRing>,
    pub(crate) programs: Vec<Program>,
    pub(crate) tickets: BTreeMap<u64, Pending>,
    pub(crate) finished: BTreeMap<u64, TicketInfo>,
    pub(crate) next_ticket: u64,
    pub(crate) recording: Option<Recording>,
    pub(crate) fault: Option<FaultInfo>,
    pub(crate) server: Option<Server>,
    pub(crate) shutdown: bool,
    /// The script waits: a full ring holds the clock back.
    pub(crate) script_waits: bool,
    /// The virtual clock may move up to here.
    pub(crate) target: i64,
    /// As far as waiting clients let it move.
    pub(crate) client_target: i64,
    retired: Vec<Retired>,
    messages: VecDeque<String>,
    ticks: (u64, i64),
    quiet: bool,
    /// Last: everything points into it.
    pub(crate) arena: Arena,
}

impl Engine {
    /// Makes an instance and takes its socket.
    ///
    /// # Errors
    /// Another one of this name is running, or the system refuses.
    pub fn new(options: Options) -> Result<Self, Failure> {
        os::catch_signals();
        let server = Server::open(&options.place)?;
        let mut engine = Self::without_socket(options)?;
        engine.server = Some(server);
        Ok(engine)
    }

    /// Makes an instance that no client can reach: for tests and benchmarks.
    ///
    /// # Errors
    /// The system refuses.
    pub fn without_socket(mut options: Options) -> Result<Self, Failure> {
        options.simulate |= options.clock == ClockKind::Virtual;
        let real = options.clock == ClockKind::Real;
        let fifo = real && std::env::var_os("HAL_NO_FIFO").is_none() && os::may_fifo();
        let cpu = real.then(|| choose_cpu(options.place.name())).flatten();
        let scheduling = match (real, fifo) {
            (false, _) => "virtual clock: all threads in one place".to_owned(),
            (true, true) => format!(
                "SCHED_FIFO, all threads on {}",
                cpu.map_or("any processor".into(), |c| format!("processor {c}"))
            ),
            (true, false) => "no SCHED_FIFO (not permitted): one ordinary thread runs all threads \
                              in turn; expect late wake-ups"
                .to_owned(),
        };
        let shared = Shared::new(options.clock);
        let kind = if fifo { Scheduling::Fifo } else { Scheduling::Timeline };
        Ok(Self {
            arena: Arena::new(fifo)?,
            graph: Graph::default(),
            counts: Counts::default(),
            loader: Loader::new(options.path.clone()),
            runners: Runners::new(shared.clone(), kind, cpu),
            scheduling,
            lock: Lock::NONE,
            next_component: 1,
            next_thread: 1,
            tasks: Vec::new(),
            rings: BTreeMap::new(),
            programs: Vec::new(),
            tickets: BTreeMap::new(),
            finished: BTreeMap::new(),
            next_ticket: 1,
            recording: None,
            fault: None,
            server: None,
            shutdown: false,
            script_waits: false,
            target: 0,
            client_target: i64::MIN,
            retired: Vec::new(),
            messages: VecDeque::new(),
            ticks: (os::ticks(), os::monotonic_ns()),
            quiet: true,
            shared,
            options,
        })
    }

    /// Offers the components of a library that is linked into this program.
    pub fn add_static(&mut self, library: &'static hal_abi::Library) {
        self.loader.add_static(library);
    }

    /// Serves clients until something ends it; `for_ns` bounds machine time.
    pub fn serve(&mut self, for_ns: Option<u64>) -> Ended {
        let limit = for_ns
            .map(|ns| self.shared.now().saturating_add(i64::try_from(ns).unwrap_or(i64::MAX)));
        let before = self.target;
        let ended = loop {
            if self.shutdown {
                break Ended::Shutdown;
            }
            if os::signalled() {
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

    /// Whether a signal or a client has asked the instance to end (a script then stops).
    #[must_use]
    pub fn is_ending(&self) -> bool {
        self.shutdown || os::signalled()
    }

    /// What components and the engine have said since the last call. The same is logged.
    pub fn take_messages(&mut self) -> Vec<String> {
        self.hear();
        self.messages.drain(..).collect()
    }

    /// Machine time in nanoseconds.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        self.shared.now()
    }

    /// Stops the threads, runs every stop action, ends programs, unloads everything and gives the
    /// socket back.
    pub fn close(mut self) {
        self.end();
    }

    fn end(&mut self) {
        if let Err(e) = self.stop_threads() {
            self.notice(e.to_string());
        }
        self.run_stops();
        if self.recording.is_some()
            && let Err(e) = self.end_recording()
        {
            self.notice(e.to_string());
        }
        self.end_programs();
        self.shared.quit.store(true, Ordering::Relaxed);
        let clean = self.runners.end(&[], true, PATIENCE_NS);
        if clean {
            for ix in self.graph.components_by_age().into_iter().rev() {
                self.remove_component(ix);
            }
            self.reap();
        } else {
            // A thread that never leaves its function still uses all of this.
            let stuck = self.stuck();
            self.notice(stuck.to_string());
            let _left = core::mem::ManuallyDrop::new((
                core::mem::take(&mut self.retired),
                core::mem::take(&mut self.graph),
                core::mem::take(&mut self.rings),
            ));
            self.arena.leave();
        }
        self.hear();
        self.server = None;
    }

    fn end_programs(&mut self) {
        for p in &self.programs {
            os::end_process(p.pid, false);
        }
        let limit = os::monotonic_ns() + PATIENCE_NS;
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
    }

    /// One turn of the control side: messages, faults, the clock, the socket. Waits at most
    /// `ms` on the wall when there is nothing to do.
    pub(crate) fn pump(&mut self, ms: i32) {
        self.hear();
        self.notice_fault();
        self.reap();
        let moved = self.advance();
        let ms = if moved { 0 } else { ms };
        crate::server::serve_once(self, ms);
    }

    /// Moves the virtual clock where it may, or runs the tasks that are due on the real one.
    fn advance(&mut self) -> bool {
        self.measure_ticks();
        let now = self.shared.now();
        if !self.shared.is_virtual() {
            self.run_tasks(now);
            self.drain_recording();
            return false;
        }
        let target = self.target.max(self.client_target);
        if now >= target || self.held_back() {
            return false;
        }
        if self.recording.as_ref().is_some_and(Recording::is_waiting) {
            self.begin_recording();
        }
        let until = target.min(self.next_task()).min(crate::server::next_poll(self));
        let instants = if crate::server::waits_for_ticket(self) { 1 } else { SLICE };
        clock::turn(&self.shared, until.max(now), instants);
        self.drain_recording();
        let now = self.shared.now();
        self.run_tasks(now);
        true
    }

    /// Moves the virtual clock by one instant of machine time, for a script that waits.
    pub(crate) fn advance_one(&mut self) {
        let now = self.shared.now();
        if self.held_back() {
            return;
        }
        let until = self.next_task().min(crate::server::next_poll(self));
        let until = until.min(now.saturating_add(1_000_000_000));
        clock::turn(&self.shared, until.max(now), 1);
        self.drain_recording();
        let now = self.shared.now();
        self.run_tasks(now);
    }

    /// Whether the virtual clock must wait for a program.
    fn held_back(&mut self) -> bool {
        let now = os::monotonic_ns();
        self.programs.retain(|p| os::alive(p.pid));
        let starting = self.programs.iter().any(|p| !p.joined && now - p.since < 1_000_000_000);
        starting
            || crate::server::owes_poll(self)
            || (self.script_waits && self.rings.values().any(SharedRing::holds_back))
    }

    /// Learns how long a tick of the cycle counter is.
    fn measure_ticks(&mut self) {
        let (ticks, ns) =
            (os::ticks().wrapping_sub(self.ticks.0), os::monotonic_ns() - self.ticks.1);
        if ns > 1_000_000 && ticks > 0 && self.shared.tick_ns().to_bits() == 1_f64.to_bits()
            || ns > 100_000_000
        {
            self.shared.set_tick_ns(ns as f64 / ticks as f64);
        }
    }

    /// Makes a change: directly while no cycle can be under way, else at a boundary.
    pub(crate) fn carry_out(&mut self, change: Change) -> Result<(), Error> {
        if change.stores.is_empty() && change.lists.is_empty() {
            return Ok(());
        }
        let running = self.shared.boundary.is_running() && !self.shared.is_virtual();
        let threads = !self.shared.threads.load().is_empty();
        if running && threads && change.stores.len() > MOST_STORES {
            return Err(Error::TooManyStores { stores: change.stores.len() });
        }
        let old: Vec<_> = change.lists.iter().map(|(t, _)| t.list.load_full()).collect();
        if running && threads {
            self.at_boundary(&change)?;
        } else {
            self.settle()?;
            change.carry_out();
        }
        self.retired.extend(old.into_iter().map(Retired::List));
        Ok(())
    }

    fn at_boundary(&self, change: &Change) -> Result<(), Error> {
        let boundary = &self.shared.boundary;
        boundary.offer(change);
        let limit = os::monotonic_ns() + PATIENCE_NS;
        while !boundary.is_taken() {
            if os::monotonic_ns() > limit && boundary.withdraw() {
                return Err(self.stuck());
            }
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        Ok(())
    }

    /// Waits until no cycle is under way; threads are stopped.
    pub(crate) fn settle(&mut self) -> Result<(), Error> {
        if self.quiet || self.shared.is_virtual() {
            return Ok(());
        }
        let threads = self.shared.threads.load_full();
        let limit = os::monotonic_ns() + PATIENCE_NS;
        for t in threads.iter() {
            while t.gate.is_inside() {
                if os::monotonic_ns() > limit {
                    return Err(self.stuck());
                }
                os::sleep_until(os::monotonic_ns() + 20_000);
            }
        }
        self.quiet = true;
        Ok(())
    }

    /// `start`.
    pub(crate) fn start_threads(&mut self) -> Result<(), Error> {
        self.unlocked(Lock::RUN, "start_threads")?;
        if let Some(f) = &self.fault {
            let in_use = self.graph.functs.get(f.funct.as_str());
            let in_use = in_use.and_then(|ix| self.graph.funct(*ix)).is_some_and(|f| f.users > 0);
            if in_use {
                return Err(Error::Faulted { funct: f.funct.as_str().into() });
            }
            self.shared.boundary.stop();
            self.settle()?;
            self.fault = None;
            self.shared.fault.clear();
        }
        if self.shared.boundary.is_running() {
            return Ok(());
        }
        self.renew_lists()?;
        if self.recording.is_some() {
            self.begin_recording();
        }
        self.measure_ticks();
        self.quiet = false;
        self.shared.boundary.start();
        Ok(())
    }

    /// `stop`, and waits for cycles under way.
    pub(crate) fn stop_threads(&mut self) -> Result<(), Error> {
        self.shared.boundary.stop();
        self.settle()
    }

    /// Keeps what threads may still use.
    pub(crate) fn retire_threads(&mut self, old: Arc<Vec<Arc<Thread>>>) {
        self.retired.push(Retired::Threads(old));
    }

    /// Keeps what threads may still use.
    pub(crate) fn retire_probe(&mut self, old: Arc<Probe>) {
        self.retired.push(Retired::Probe(old));
    }

    /// Frees what no thread uses any more.
    pub(crate) fn reap(&mut self) {
        if self.retired.iter().any(Retired::is_free) {
            self.hear();
            self.retired.retain(|r| !r.is_free());
        }
    }

    /// Which thread does not leave its cycle.
    pub(crate) fn stuck(&self) -> Error {
        for ix in self.graph.threads_by_age() {
            let Some(t) = self.graph.thread(ix) else { continue };
            if t.thread.gate.is_inside() {
                let funct = self.funct_name(t.thread.current.load(Ordering::Relaxed));
                return Error::Stuck { thread: t.name.as_str().into(), funct: funct.into() };
            }
        }
        Error::Stuck { thread: "?".into(), funct: "?".into() }
    }

    /// The name of a function by its number.
    pub(crate) fn funct_name(&self, id: u32) -> String {
        let funct = self.graph.funct(Ix::from(id));
        funct.map_or_else(|| "?".to_owned(), |f| f.name.as_str().to_owned())
    }

    /// What to do when a function has failed: stop everything, outputs to their safe levels.
    fn notice_fault(&mut self) {
        let Some((thread, funct)) = self.shared.fault.get() else { return };
        if self.fault.is_some() {
            return;
        }
        let threads = self.shared.threads.load_full();
        let slowest = threads.iter().map(|t| t.period_ns).max().unwrap_or(0);
        let limit = os::monotonic_ns() + slowest.saturating_mul(2);
        while threads.iter().any(|t| t.gate.is_inside()) && os::monotonic_ns() < limit {
            os::sleep_until(os::monotonic_ns() + 20_000);
        }
        self.run_stops();
        let thread = self
            .graph
            .threads
            .values()
            .filter_map(|ix| self.graph.thread(*ix))
            .find(|t| t.thread.id == thread)
            .map_or("?", |t| t.name.as_str());
        let owner = self.graph.owner(Ix::from(funct)).map_or("?", |c| c.name.as_str());
        let info = FaultInfo {
            component: owner.to_owned(),
            funct: self.funct_name(funct),
            thread: thread.to_owned(),
            cause: self.shared.cause.text(),
        };
        self.notice(format!(
            "function '{}' of component '{}' failed in thread '{}': {}; all threads are stopped \
             and outputs are at their safe levels",
            info.funct, info.component, info.thread, info.cause
        ));
        self.fault = Some(info);
    }

    /// Runs every stop action.
    pub(crate) fn run_stops(&mut self) {
        let mut failed = Vec::new();
        for ix in self.graph.components_by_age() {
            let Some(c) = self.graph.component(ix) else { continue };
            for stop in &c.stops {
                if let Err(e) = stop.call(crate::args::Args::default()) {
                    failed.push(format!("{}: stop action: {e}", c.name));
                }
            }
        }
        failed.into_iter().for_each(|f| self.notice(f));
    }

    /// How far a command has come.
    pub(crate) fn ticket(&mut self, id: u64) -> Result<TicketInfo, Error> {
        if let Some(done) = self.finished.get(&id) {
            return Ok(done.clone());
        }
        let pending = self.tickets.get(&id).ok_or(Error::NoTicket { id })?;
        let info = match pending.ticket.state() {
            TicketState::Pending => return Ok(TicketInfo::Pending),
            TicketState::Done => TicketInfo::Done,
            TicketState::Failed(why) => TicketInfo::Failed(why.to_owned()),
        };
        self.tickets.remove(&id);
        self.finished.insert(id, info.clone());
        while self.finished.len() > 1000 {
            self.finished.pop_first();
        }
        Ok(info)
    }

    /// Whether a lock forbids something.
    pub(crate) const fn unlocked(&self, lock: Lock, what: &'static str) -> Result<(), Error> {
        if self.lock.0 & lock.0 == 0 { Ok(()) } else { Err(Error::Locked { what }) }
    }

    /// Logs something of the engine's own.
    pub(crate) fn notice(&mut self, text: String) {
        tracing::warn!("{text}");
        self.keep_message(text);
    }

    fn keep_message(&mut self, text: String) {
        if self.messages.len() >= 1000 {
            self.messages.pop_front();
        }
        self.messages.push_back(text);
    }

    /// Logs what components have said.
    pub(crate) fn hear(&mut self) {
        while let Some(m) = self.shared.heard() {
            let text = self.worded(&m);
            match m.level {
                level::ERR => tracing::error!("{text}"),
                level::WARN => tracing::warn!("{text}"),
                level::INFO => tracing::info!("{text}"),
                _ => tracing::debug!("{text}"),
            }
            self.keep_message(text);
        }
        let lost = self.shared.lost_messages.swap(0, Ordering::Relaxed);
        if lost > 0 {
            self.notice(format!("{lost} messages of components were lost: too many at once"));
        }
    }

    fn worded(&self, m: &Message) -> String {
        // SAFETY: static in a library that is open: messages are heard before one is closed.
        let text = unsafe { m.text.get() }.unwrap_or("?");
        let said = m
            .numbers
            .iter()
            .take(m.n)
            .fold(text.to_owned(), |s, x| s.replacen("{}", &x.to_string(), 1));
        let by = self
            .graph
            .components
            .values()
            .filter_map(|ix| self.graph.component(*ix))
            .find(|c| c.id == m.component)
            .map_or("?", |c| c.name.as_str());
        format!("{by}: {said}")
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        if !self.shared.quit.load(Ordering::Relaxed) {
            self.end();
        }
    }
}

/// The processor for all threads of an instance: as asked, else spread by name, the last first.
fn choose_cpu(instance: &str) -> Option<usize> {
    let cpus = os::cpus();
    if let Ok(asked) = std::env::var("HAL_CPU") {
        return asked.parse().ok().filter(|c| cpus.contains(c));
    }
    let spread = if instance == "default" { 0 } else { instance.bytes().map(usize::from).sum() };
    let n = cpus.len();
    if n < 2 { None } else { cpus.get((n - 1 + n - spread % n) % n).copied() }
}

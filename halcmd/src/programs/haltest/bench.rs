//! The engine of a test. Every request that moves its clock moves it cycle by cycle, so that forced
//! values, ramps and dropped pulses take effect in the intended cycle.

use super::inject::{ENOENT, Faults, Ramping};
use crate::session::INTERRUPTED;
use hal_engine::Engine;
use hal_protocol::{Failure, Kind, Link, Reply, Request, TicketInfo, Value};
use std::collections::BTreeSet;

/// Failure code for an exceeded time limit.
const ETIME: i32 = -62;
/// Step of the clock in nanoseconds while there is no thread.
const WITHOUT_THREADS_NS: u64 = 1_000_000;

/// Number of cycles between two checks for stopped threads.
const LOOKS: u32 = 256;

/// The engine with the ramps and faults of a test.
pub(super) struct Bench {
    engine: Engine,
    /// Messages with their times.
    pub(super) said: Vec<(i64, String)>,
    pub(super) ramps: Vec<Ramping>,
    pub(super) faults: Faults,
    /// Machine time at which the test is aborted.
    end: i64,
    limit_ns: u64,
    period: Option<u64>,
    /// Names that are those of signals, and of no pin, as long as nothing is loaded.
    signals: BTreeSet<String>,
}

impl Bench {
    /// Wraps an engine that may run for `limit_ns`, and that first executes the machine's script.
    pub(super) fn new(mut engine: Engine, limit_ns: u64) -> Self {
        engine.set_starting(true);
        let end = engine.now_ns().saturating_add(i64::try_from(limit_ns).unwrap_or(i64::MAX));
        Self {
            engine,
            said: Vec::new(),
            ramps: Vec::new(),
            faults: Faults::default(),
            end,
            limit_ns,
            period: None,
            signals: BTreeSet::new(),
        }
    }

    /// Returns the machine time in nanoseconds.
    pub(super) fn now(&self) -> i64 {
        self.engine.now_ns()
    }

    /// Closes the engine and returns all messages, including the last ones.
    pub(super) fn close(mut self) -> Vec<(i64, String)> {
        self.drain_messages();
        self.engine.close();
        self.said
    }

    /// Executes a request directly in the engine, without the ramps and faults of the test.
    pub(super) fn ask(&mut self, request: Request) -> Result<Reply, Failure> {
        let reply = self.engine.call(request);
        self.drain_messages();
        reply
    }

    /// Returns the value of a pin, parameter or signal.
    pub(super) fn get(&mut self, name: &str) -> Result<Value, Failure> {
        // A condition asks in every cycle, and a name that is not found costs a search for a near one.
        if self.signals.contains(name)
            && let Ok(Reply::Value(value)) =
                self.engine.call(Request::GetSignal { name: name.to_owned() })
        {
            return Ok(value);
        }
        let of_item = match self.engine.call(Request::Get { name: name.to_owned() }) {
            Ok(Reply::Value(value)) => return Ok(value),
            Ok(_) => Failure::new(ENOENT, "no value"),
            Err(failure) => failure,
        };
        match self.engine.call(Request::GetSignal { name: name.to_owned() }) {
            Ok(Reply::Value(value)) => {
                self.signals.insert(name.to_owned());
                Ok(value)
            }
            // Of the two failures, prefer the one that knows a near name.
            Err(of_signal) if of_item.hint.is_none() && of_signal.hint.is_some() => Err(of_signal),
            Ok(_) | Err(_) => Err(of_item),
        }
    }

    /// Advances time to the next cycle of the fastest thread, but not past `until`.
    pub(super) fn cycle(&mut self, until: i64) -> Result<(), Failure> {
        let now = self.now();
        if now >= self.end {
            let limit = crate::language::units::duration(self.limit_ns);
            let text = format!("the machine has run for {limit}, which is the test's limit");
            return Err(Failure::new(ETIME, text));
        }
        let period = self.period()?;
        let left = u64::try_from(until.min(self.end).saturating_sub(now)).unwrap_or(0);
        let before = now;
        Ramping::take_effect(self)?;
        let reply = self.engine.call(Request::Run { ns: period.min(left) });
        self.drain_messages();
        reply?;
        if self.engine.is_ending() {
            return Err(ending());
        }
        if self.now() > before { Faults::look(self) } else { Ok(()) }
    }

    /// Returns the period of the fastest thread in nanoseconds.
    fn period(&mut self) -> Result<u64, Failure> {
        if let Some(period) = self.period {
            return Ok(period);
        }
        let all = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
        let Reply::Threads(threads) = self.engine.call(all)? else { return Ok(WITHOUT_THREADS_NS) };
        let least = threads.iter().filter_map(|t| u64::try_from(t.period).ok()).min();
        self.period = least;
        Ok(least.unwrap_or(WITHOUT_THREADS_NS))
    }

    fn run(&mut self, ns: u64) -> Result<Reply, Failure> {
        let ns = i64::try_from(ns).unwrap_or(i64::MAX);
        let until = self.now().saturating_add(ns);
        if self.ramps.is_empty() && !self.faults.is_looking() && until <= self.end {
            return self.engine.call(Request::Run { ns: ns.unsigned_abs() });
        }
        while self.now() < until {
            self.cycle(until)?;
        }
        Ok(Reply::Done)
    }

    fn ticket(&mut self, id: u64) -> Result<Reply, Failure> {
        loop {
            let reply = self.engine.call(Request::Ticket { id, wait: false })?;
            if reply != Reply::Ticket(TicketInfo::Pending) || self.has_stopped()? {
                return Ok(reply);
            }
            for _ in 0..LOOKS {
                let reply = self.engine.call(Request::Ticket { id, wait: false })?;
                if reply != Reply::Ticket(TicketInfo::Pending) {
                    return Ok(reply);
                }
                self.cycle(i64::MAX)?;
            }
        }
    }

    /// Returns whether the threads have stopped because a component failed.
    pub(super) fn has_stopped(&mut self) -> Result<bool, Failure> {
        let reply = self.engine.call(Request::Status)?;
        Ok(matches!(reply, Reply::Status(status) if status.fault.is_some()))
    }

    fn drain_messages(&mut self) {
        let now = self.engine.now_ns();
        self.said.extend(self.engine.take_messages().into_iter().map(|text| (now, text)));
    }
}

impl Link for Bench {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        if self.engine.is_ending() {
            return Err(ending());
        }
        if matches!(request, Request::Load { .. } | Request::Unload { .. } | Request::UnloadAll) {
            self.period = None;
            self.signals.clear();
        }
        let reply = match request {
            Request::Run { ns } => self.run(ns),
            Request::Ticket { id, wait: true } => self.ticket(id),
            other => self.engine.call(other),
        };
        self.drain_messages();
        reply
    }

    fn at(&mut self, file: &str, line: u32) {
        self.engine.at(file, line);
    }

    fn set_starting(&mut self, is_starting: bool) {
        self.engine.set_starting(is_starting);
    }

    fn is_local(&self) -> bool {
        true
    }

    fn is_ending(&self) -> bool {
        self.engine.is_ending()
    }
}

fn ending() -> Failure {
    Failure::new(INTERRUPTED, "the instance is ending")
}

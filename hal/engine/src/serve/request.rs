//! Execution of requests, one by one.

use crate::{
    Engine, Error, error::watch::WatchError, load::args::Args, name::Name, os,
    realtime::shared::MAX_TIME_NS, serve::clients::Program, sync::Ordering,
};
use hal_protocol::{Answer, Failure, Kind, LATEST, Link, Patterns, Reply, Request, TicketInfo};

impl Engine {
    /// Executes a request that needs no client and no waiting.
    pub(crate) fn carry(&mut self, request: Request) -> Result<Reply, Error> {
        self.notice_fault();
        match request {
            // One after the other, each as a transaction: together they may be too many stores.
            Request::UnloadAll => {
                while let Some(name) = self.model.newest() {
                    self.whole(|e| e.model.unload(name.as_str()))?;
                }
            }
            Request::DeleteSignal { name: None } => {
                let names: Vec<Name> = self.model.graph().signals.keys().cloned().collect();
                if names.is_empty() {
                    return Err(Error::NoSignals);
                }
                for name in names {
                    self.whole(|e| e.model.delete_signal(name.as_str()))?;
                }
            }
            Request::Apply { files, edits, dry } => return self.apply(&files, &edits, dry),
            Request::Get { name } => return Ok(Reply::Value(self.model.get_item(&name)?)),
            Request::GetSignal { name } => return Ok(Reply::Value(self.model.get_signal(&name)?)),
            Request::Stop => {
                self.model.unlocked(hal_protocol::Lock::RUN, "stop_threads")?;
                self.runtime.stop()?;
            }
            Request::List { kind: Kind::Workers, patterns, .. } => {
                return Ok(Reply::Workers(self.workers.list(&Patterns::new(&patterns))));
            }
            Request::List { kind: Kind::Snapshots, patterns, .. } => {
                return Ok(Reply::Snapshots(self.snapshots.list(&Patterns::new(&patterns))));
            }
            Request::List { kind, patterns, ty } => {
                return Ok(self.model.list(kind, &patterns, ty));
            }
            Request::Order => return Ok(Reply::Order(Box::new(self.order()))),
            Request::Check => return Ok(Reply::Findings(self.check())),
            Request::Snapshot { name } => {
                return Ok(Reply::Snapshot(Box::new(self.snapshots.values(&name)?)));
            }
            Request::MapSnapshot { .. } => return Err(Error::NoSocket),
            Request::Status => return Ok(Reply::Status(Box::new(self.status()))),
            Request::Component { name } => {
                let ix = self.model.graph().components.get(name.as_str()).copied();
                let info = ix.and_then(|ix| self.model.component_info(ix));
                return Ok(Reply::Components(info.into_iter().collect()));
            }
            Request::Timing { thread, on } => self.model.time_functs(thread.as_deref(), on)?,
            Request::MessageLevel { level } => {
                self.runtime.shared().mailbox.level.store(level, Ordering::Relaxed);
            }
            Request::Command { name, args } => return self.command(&name, &args),
            Request::Adopt { pid, .. } if pid <= 1 || pid == os::own_pid() => {
                let why = format!("{pid} is not the number of a program").into();
                return Err(Error::Protocol { why });
            }
            // The virtual clock waits for the start of a program once.
            Request::Adopt { pid, .. } if self.clients.programs.iter().any(|p| p.pid == pid) => {}
            Request::Adopt { pid, program } => {
                let since = os::monotonic_ns();
                let joined = self.model.graph().components.values().any(|ix| {
                    self.model.graph().component(*ix).is_some_and(|c| c.pid == Some(pid))
                });
                self.clients.programs.push(Program { pid, name: program, since, joined });
                self.clients.publish_programs(self.runtime.instance());
            }
            Request::EndProgram { name } => self.end_program(name.as_deref())?,
            Request::Record { path, patterns } => self.record(&path, &patterns)?,
            Request::EndRecord => self.end_recording()?,
            Request::Flight(spec) => self.begin_flight(spec)?,
            Request::EndFlight => self.end_flight()?,
            Request::SaveFlight { path, last } => self.save_flight(&path, last)?,
            Request::FlightState => return Ok(Reply::Flight(self.flight_info()?)),
            Request::Sample(_) => return Err(WatchError::Here.into()),
            Request::SampleState { id } => {
                return Ok(Reply::SampleState(self.sample_state(0, id)?));
            }
            Request::EndSample { id } => return Ok(Reply::SampleState(self.end_sample(0, id)?)),
            Request::Shutdown => self.clients.shutdown = true,
            edit => {
                self.whole(|e| e.stage(&edit).unwrap_or(Err(Error::NotAMember)))?;
            }
        }
        Ok(Reply::Done)
    }

    /// `COMPONENT.VERB name=value …`.
    fn command(&mut self, name: &str, words: &[String]) -> Result<Reply, Error> {
        let owner = crate::graph::find(&self.model.graph().commands, "command", name)?;
        let component = self.model.graph().component(owner);
        let command = component
            .and_then(|c| c.commands.iter().find(|c| c.name.as_str() == name))
            .ok_or_else(|| Error::NotFound {
            what: "command",
            name: name.into(),
            near: None,
        })?;
        let args = Args::parse(&command.args, &[], words)?;
        let outcome = {
            let _within = self.runtime.control().run(command.doing.clone());
            command.code.call(args)?
        };
        let ticket = outcome.ticket.map(|ticket| self.clients.await_result(owner, ticket));
        let awaited = outcome.awaited && ticket.is_some();
        Ok(Reply::Answer(Answer { lines: outcome.lines, ticket, awaited }))
    }

    /// `unloadusr`.
    fn end_program(&mut self, name: Option<&str>) -> Result<(), Error> {
        let programs: Vec<(String, i32)> = self
            .model
            .graph()
            .components
            .values()
            .filter_map(|ix| self.model.graph().component(*ix))
            .filter_map(|c| Some((c.name.as_str().to_owned(), c.pid?)))
            .filter(|(n, _)| !n.starts_with("halcmd"))
            .collect();
        match name {
            Some(name) => {
                if let Some(ix) = self.model.graph().components.get(name)
                    && self.model.graph().component(*ix).is_some_and(|c| c.realtime)
                {
                    return Err(Error::NotAProgram { name: name.into() });
                }
                if let Some((_, pid)) = programs.iter().find(|(n, _)| n == name) {
                    os::end_process(*pid, false);
                }
            }
            None => programs.iter().for_each(|(_, pid)| os::end_process(*pid, false)),
        }
        Ok(())
    }

    /// Returns the machine time at which a `run` of `ns` nanoseconds ends.
    pub(crate) fn run_end(&self, ns: u64) -> Result<i64, Error> {
        if !self.runtime.is_virtual() {
            return Err(Error::NotVirtual);
        }
        let now = self.runtime.now();
        let end = i64::try_from(ns).ok().and_then(|ns| now.checked_add(ns));
        end.filter(|end| *end <= MAX_TIME_NS).ok_or_else(|| Error::OutOfRange {
            what: "time",
            name: format!("{ns} ns").into(),
            expects: "the virtual clock ends after 146 years",
        })
    }

    /// Waits for `ms` milliseconds of wall-clock time; `flow` lets the virtual clock move
    /// meanwhile.
    fn idle(&mut self, ms: u32, flow: bool) {
        let end = os::monotonic_ns() + i64::from(ms) * 1_000_000;
        let before = self.clients.target;
        if flow && !self.options.hold {
            self.clients.target = i64::MAX;
            self.clients.script_waits = true;
        }
        loop {
            let left = (end - os::monotonic_ns()) / 1_000_000;
            self.pump(i32::try_from(left.max(0)).unwrap_or(1));
            if os::monotonic_ns() >= end || self.is_ending() {
                break;
            }
        }
        self.clients.target = before;
        self.clients.script_waits = false;
    }

    /// Waits until every program whose poll is due has polled: otherwise it would be a matter of
    /// chance what the program sees of the next line of a script.
    fn settle_polls(&mut self) {
        while self.runtime.is_virtual()
            && !self.is_ending()
            && !crate::serve::polls::has_polled(self)
        {
            self.pump(1);
        }
    }

    fn wait_for_ticket(&mut self, id: u64) -> Result<TicketInfo, Error> {
        loop {
            // Enough instants between checks of the socket that the check costs nothing.
            for _ in 0..4096 {
                let info = self.result(id)?;
                if info != TicketInfo::Pending || self.is_ending() || self.runtime.fault().is_some()
                {
                    self.settle_polls();
                    return Ok(info);
                }
                if !self.runtime.is_virtual() {
                    break;
                }
                if self.runtime.is_idle() && !self.runtime.has_tasks() && self.workers.is_empty() {
                    return Err(Error::NotStarted);
                }
                if !self.advance_one() {
                    break;
                }
                if self.runtime.shared().fault.get().is_some() {
                    break;
                }
            }
            self.pump(i32::from(!self.runtime.is_virtual()));
        }
    }
}

impl Link for Engine {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        self.runtime.control().beat();
        if let Some(reply) = self.try_only(&request) {
            return Ok(reply?);
        }
        let reply = match request {
            Request::Hello { .. } => Reply::Hello {
                protocol: LATEST,
                instance: self.options.place.name().to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
                id: 0,
            },
            Request::Run { ns } => {
                let end = self.run_end(ns)?;
                let before = core::mem::replace(&mut self.clients.target, end);
                while self.runtime.now() < end && !self.is_ending() {
                    self.pump(1);
                }
                self.settle_polls();
                self.clients.target = before;
                Reply::Done
            }
            Request::Ticket { id, wait } => {
                let info = if wait { self.wait_for_ticket(id)? } else { self.result(id)? };
                Reply::Ticket(info)
            }
            Request::Idle { ms, flow } => {
                self.idle(ms, flow);
                Reply::Done
            }
            Request::Await { ms, pid } => {
                self.clients.waits_for = Some(pid);
                self.idle(ms, true);
                self.clients.waits_for = None;
                Reply::Done
            }
            other => {
                let reply = self.carry(other)?;
                self.hear();
                reply
            }
        };
        Ok(reply)
    }

    fn at(&mut self, file: &str, line: u32) {
        self.model.stand(file, line);
    }

    fn is_local(&self) -> bool {
        true
    }
}

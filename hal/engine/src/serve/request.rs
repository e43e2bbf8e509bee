//! Execution of requests by class, and the waits of a script.

use crate::{
    Engine, Error, error::watch::WatchError, load::args::Args, name::Name, os,
    serve::client::WaitState, serve::clients::Program, serve::dispatch::Answer, sync::Ordering,
};
use hal_protocol::{
    ActionRequest, EditRequest, Failure, Kind, LATEST, Link, OutsideRequest, OwnRequest, Patterns,
    QueryRequest, Reply, Request, TicketInfo,
};

impl Engine {
    /// Executes an edit as a transaction of its own.
    pub(crate) fn edit(&mut self, request: EditRequest) -> Result<Reply, Error> {
        match request {
            // One after the other, each as a transaction: together they may be too many stores.
            EditRequest::UnloadAll => {
                while let Some(name) = self.model.newest() {
                    self.transact(|e| e.model.unload(name.as_str()))?;
                }
            }
            EditRequest::DeleteSignal { name: None } => {
                let names = self.model.graph().signal_names();
                let names: Vec<Name> = names.into_iter().map(|(name, _)| name.clone()).collect();
                if names.is_empty() {
                    return Err(Error::NoSignals);
                }
                for name in names {
                    self.transact(|e| e.model.delete_signal(name.as_str()))?;
                }
            }
            edit => {
                self.transact(|e| e.stage(&edit))?;
            }
        }
        Ok(Reply::Done)
    }

    /// Answers a question.
    pub(crate) fn query(&mut self, request: QueryRequest) -> Result<Reply, Error> {
        Ok(match request {
            QueryRequest::Get { name } => Reply::Value(self.model.get_item(&name)?),
            QueryRequest::GetSignal { name } => Reply::Value(self.model.get_signal(&name)?),
            QueryRequest::List { kind: Kind::Workers, patterns, .. } => {
                Reply::Workers(self.workers.list(&Patterns::new(&patterns)))
            }
            QueryRequest::List { kind: Kind::Snapshots, patterns, .. } => {
                Reply::Snapshots(self.snapshots.list(&Patterns::new(&patterns)))
            }
            QueryRequest::List { kind, patterns, ty } => self.model.list(kind, &patterns, ty),
            QueryRequest::Snapshot { name } => {
                Reply::Snapshot(Box::new(self.snapshots.values(&name)?))
            }
            QueryRequest::Order => Reply::Order(Box::new(self.order())),
            QueryRequest::Check => Reply::Findings(self.check()),
            QueryRequest::Status => Reply::Status(Box::new(self.status())),
            QueryRequest::Component { name } => {
                let ix = self.model.graph().components.get(name.as_str()).copied();
                let info = ix.and_then(|ix| self.model.component_info(ix));
                Reply::Components(info.into_iter().collect())
            }
            QueryRequest::FlightState => Reply::Flight(self.flight_info()?),
        })
    }

    /// Acts on the machine, for people elsewhere or for those here.
    pub(crate) fn act(
        &mut self,
        request: ActionRequest,
        is_from_afar: bool,
    ) -> Result<Reply, Error> {
        match request {
            ActionRequest::Apply { files, edits, dry } => return self.apply(&files, edits, dry),
            ActionRequest::Stop => {
                self.model.unlocked(hal_protocol::Lock::RUN, "stop_threads")?;
                self.runtime.stop_by_command()?;
            }
            ActionRequest::Timing { thread, on } => {
                self.model.time_functs(thread.as_deref(), on)?;
            }
            ActionRequest::MessageLevel { level } => {
                self.runtime.shared().mailbox.level.store(level, Ordering::Relaxed);
            }
            ActionRequest::Command { name, args } => {
                return self.command(&name, &args, is_from_afar);
            }
            ActionRequest::Shutdown => self.clients.shutdown = true,
        }
        Ok(Reply::Done)
    }

    /// Acts on programs and files.
    pub(crate) fn act_outside(&mut self, request: OutsideRequest) -> Result<Reply, Error> {
        match request {
            OutsideRequest::Adopt { pid, program } => self.adopt(pid, program)?,
            OutsideRequest::EndProgram { name } => self.end_program(name.as_deref())?,
            OutsideRequest::Record { path, patterns } => self.record(&path, &patterns)?,
            OutsideRequest::EndRecord => self.end_recording()?,
            OutsideRequest::Flight(spec) => self.begin_flight(spec)?,
            OutsideRequest::EndFlight => self.end_flight()?,
            OutsideRequest::SaveFlight { path, last } => self.save_flight(&path, last)?,
        }
        Ok(Reply::Done)
    }

    /// Handles a request of the script that concerns the script itself.
    pub(crate) fn own_of_script(&mut self, request: OwnRequest) -> Result<Reply, Error> {
        Ok(match request {
            OwnRequest::Hello { .. } => Reply::Hello {
                protocol: LATEST,
                instance: self.options.place.name().to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
                id: 0,
            },
            OwnRequest::MapSnapshot { .. } => return Err(Error::NoSocket),
            OwnRequest::Sample(_) => return Err(WatchError::Here.into()),
            OwnRequest::SampleState { id } => Reply::SampleState(self.sample_state(0, id)?),
            OwnRequest::EndSample { id } => Reply::SampleState(self.end_sample(0, id)?),
            OwnRequest::Join { .. }
            | OwnRequest::NewPin { .. }
            | OwnRequest::Ready
            | OwnRequest::Unready
            | OwnRequest::Leave
            | OwnRequest::SharePins { .. }
            | OwnRequest::AtEnd { .. }
            | OwnRequest::SpeakFromAfar
            | OwnRequest::Sleep { .. }
            | OwnRequest::Poll { .. }
            | OwnRequest::NewStream { .. }
            | OwnRequest::Attach { .. } => return Err(Error::NotAMember),
        })
    }

    /// Adds a program that a script has started. The virtual clock waits for its start once.
    fn adopt(&mut self, pid: i32, program: String) -> Result<(), Error> {
        if pid <= 1 || pid == os::own_pid() {
            let why = format!("{pid} is not the number of a program").into();
            return Err(Error::Protocol { why });
        }
        if self.clients.programs.iter().any(|p| p.pid == pid) {
            return Ok(());
        }
        let since = os::monotonic_ns();
        let graph = self.model.graph();
        let mut components = graph.components.values().filter_map(|ix| graph.component(*ix));
        let joined = components.any(|c| c.pid == Some(pid));
        self.clients.programs.push(Program { pid, name: program, since, joined });
        self.clients.publish_programs(self.runtime.instance());
        Ok(())
    }

    /// `COMPONENT.VERB name=value …`, given by people elsewhere or by those here.
    pub(in crate::serve) fn command(
        &mut self,
        name: &str,
        words: &[String],
        is_from_afar: bool,
    ) -> Result<Reply, Error> {
        let owner = crate::graph::find(&self.model.graph().commands, "command", name)?;
        let component = self.model.graph().component(owner);
        let command = component
            .and_then(|c| c.commands.iter().find(|c| c.name.as_str() == name))
            .ok_or_else(|| Error::NotFound {
            what: "command",
            name: name.into(),
            near: None,
        })?;
        let mut args = Args::parse(&command.args, &[], words)?;
        if is_from_afar {
            args.come_from_afar();
        }
        let outcome = {
            let _within = self.runtime.control().run(command.doing.clone());
            command.code.call(args)?
        };
        let ticket = outcome.ticket.map(|ticket| self.clients.await_result(owner, ticket));
        let awaited = outcome.awaited && ticket.is_some();
        Ok(Reply::Answer(hal_protocol::Answer { lines: outcome.lines, ticket, awaited }))
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

    /// Waits until this monotonic wall-clock time in nanoseconds; `flow` lets the virtual clock move
    /// meanwhile.
    fn idle(&mut self, end: i64, flow: bool) {
        let before = self.clients.target;
        if flow {
            self.clients.target = i64::MAX;
            self.clients.script_waits = true;
        }
        loop {
            let left = (end - os::monotonic_ns()) / 1_000_000;
            self.pump(i32::try_from(left.max(0)).unwrap_or(1));
            if os::monotonic_ns() >= end || self.is_ending() || self.clients.has_awaited {
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
        // Steps and items of the workers when one of them last found something to do.
        let mut busy = self.workers.progress();
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
                if self.runtime.is_idle() && !self.runtime.has_tasks() {
                    // Without threads, a worker can complete the command, unless it finds nothing to
                    // do.
                    let (steps, items) = self.workers.progress();
                    if items > busy.1 {
                        busy = (steps, items);
                    } else if self.workers.is_empty() || steps > busy.0.saturating_add(1) {
                        return Err(Error::NotStarted);
                    }
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
        let awaited = match request {
            Request::Await { pid, .. } => Some(pid),
            _ => None,
        };
        if !self.runtime.is_virtual() {
            self.take_pages();
        }
        let is_result = matches!(request, Request::Ticket { wait: true, .. });
        Ok(match self.dispatch(request, None)? {
            Answer::Now(reply) => {
                if is_result {
                    self.settle_polls();
                }
                self.drain_messages();
                reply
            }
            Answer::After(WaitState::Time(end), _) => {
                let before = core::mem::replace(&mut self.clients.target, end);
                while self.runtime.now() < end && !self.is_ending() {
                    self.pump(1);
                }
                self.settle_polls();
                self.clients.target = before;
                Reply::Done
            }
            Answer::After(WaitState::Ticket(id), _) => Reply::Ticket(self.wait_for_ticket(id)?),
            Answer::After(WaitState::Wall(end), flow) => {
                self.clients.waits_for = awaited;
                self.idle(end, flow);
                (self.clients.waits_for, self.clients.has_awaited) = (None, false);
                Reply::Done
            }
            Answer::After(WaitState::No | WaitState::Poll(_), _) => {
                return Err(Error::NotAMember.into());
            }
        })
    }

    fn at(&mut self, file: &str, line: u32) {
        self.model.stand(file, line);
    }

    fn set_starting(&mut self, is_starting: bool) {
        self.is_starting = is_starting;
    }

    fn is_local(&self) -> bool {
        true
    }
}

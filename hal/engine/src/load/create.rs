//! The declarations that a component makes while it is created, one call for each.

use crate::{
    Engine, Error,
    ends::{self, Activity, Doing},
    graph::new_item::NewItem,
    graph::{Command, Edge, Funct, Ix, Service},
    load::args::{Args, Declared},
    load::code::{Code, LoadHandle},
    load::earlier,
    name::Name,
    observe::ring::SharedRing,
    observe::snapshot::Snapshot,
    realtime::task::Task,
    realtime::worker,
    sync::Arc,
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{
    ActionSpec, CommandRun, CommandSpec, FunctSpec, ItemSpec, ServiceRef, ServiceSpec, Slot,
    SnapshotRef, SnapshotSpec, Status, Str, StreamRef, StreamSpec, TaskSpec, ThreadSpec, Use,
    WorkerSpec, access, funct_flags, item_flags, thread_flags,
};
use hal_protocol::{Direction, Type};
use std::collections::{BTreeMap, BTreeSet};

/// A load in progress.
pub(crate) struct Creating<'e> {
    pub(crate) engine: &'e mut Engine,
    pub(crate) component: Ix,
    pub(crate) keep: Arc<LoadHandle>,
    pub(crate) args: Args,
    /// The error of a refused declaration.
    pub(crate) refused: Option<Error>,
    /// The component's own description of its failure.
    pub(crate) failed: Option<String>,
    pub(crate) opens: Vec<Code<CommandRun>>,
    pub(crate) threads: Vec<Ix>,
    /// Slots of the instance in progress, to resolve the uses of its functions.
    slots: BTreeMap<usize, Ix>,
    /// Functions that write and read hidden state.
    hidden: Vec<(Ix, u64, u32)>,
}

impl<'e> Creating<'e> {
    pub(crate) const fn new(
        engine: &'e mut Engine,
        component: Ix,
        keep: Arc<LoadHandle>,
        args: Args,
    ) -> Self {
        Self {
            engine,
            component,
            keep,
            args,
            refused: None,
            failed: None,
            opens: Vec::new(),
            threads: Vec::new(),
            slots: BTreeMap::new(),
            hidden: Vec::new(),
        }
    }

    /// Begins the declarations of the next instance.
    pub(crate) fn next_instance(&mut self) {
        self.slots.clear();
    }

    /// Draws the edges for the items that a function accesses, and records its hidden state.
    fn draw_uses(&mut self, funct: Ix, uses: &[Use]) {
        for u in uses {
            if u.slot.is_null() {
                self.hidden.push((funct, u.token, u.access));
                continue;
            }
            let at = self.slots.get(&u.slot.addr()).copied();
            let Some(item) = at.or_else(|| self.engine.model.graph().item_at(u.slot)) else {
                continue;
            };
            let model = &mut self.engine.model;
            if u.access & access::READ != 0 {
                model.connect(item, funct, Edge::Reads);
            }
            if u.access & access::WRITE != 0 {
                model.connect(funct, item, Edge::Writes);
            }
        }
    }

    /// Draws the edges for hidden state, after the whole load is declared.
    pub(crate) fn draw_edges(&mut self) {
        let hidden = core::mem::take(&mut self.hidden);
        let mut takers: BTreeMap<u64, Vec<Ix>> = BTreeMap::new();
        for (taker, token, _) in hidden.iter().filter(|h| h.2 & access::READ != 0) {
            takers.entry(*token).or_default().push(*taker);
        }
        let given = hidden.iter().filter(|h| h.2 & access::WRITE != 0);
        let given: BTreeSet<u64> = given.map(|h| h.1).collect();
        for (_, told) in takers.iter().filter(|(token, _)| !given.contains(token)) {
            for taker in told {
                self.engine.model.takes_hidden_state(*taker);
            }
        }
        // In the order of the functions: a token is an address, whose order is random.
        for (giver, token, _) in hidden.iter().filter(|h| h.2 & access::WRITE != 0) {
            for taker in takers.get(token).into_iter().flatten().filter(|taker| *taker != giver) {
                self.engine.model.connect(*giver, *taker, Edge::HandsOver);
            }
        }
    }

    pub(crate) fn item(&mut self, spec: &ItemSpec) -> Result<Option<NonNull<Slot>>, Error> {
        self.item_of(spec, self.component).map(|(_, slot)| slot)
    }

    /// Creates a pin or parameter of `owner`: this component, or another for which its code
    /// declares it.
    pub(crate) fn item_of(
        &mut self,
        spec: &ItemSpec,
        owner: Ix,
    ) -> Result<(Ix, Option<NonNull<Slot>>), Error> {
        let ty = Type::from_code(spec.ty);
        let direction = match spec.dir {
            hal_abi::dir::IN => Some(Direction::In),
            hal_abi::dir::OUT => Some(Direction::Out),
            hal_abi::dir::IO => Some(Direction::Io),
            hal_abi::dir::RO => Some(Direction::Ro),
            hal_abi::dir::RW => Some(Direction::Rw),
            _ => None,
        };
        let (Some(ty), Some(direction)) = (ty, direction) else {
            return Err(self.malformed("an item has no known type or direction"));
        };
        let (name, old) = (self.text(spec.name)?, self.text(spec.old_name)?);
        let doc = self.text(spec.doc)?;
        let what = if direction.is_pin() { "pin" } else { "parameter" };
        let (name, other) = match (old.is_empty(), self.engine.options.old_names) {
            (false, true) => (Name::parse(what, old)?, Some(Name::parse(what, name)?)),
            _ => (Name::parse(what, name)?, None),
        };
        self.engine.model.note_former(what, old, &name)?;
        let doc = self.engine.model.doc(doc);
        let owned_by = self.engine.model.graph().component(owner);
        let asked = owned_by.filter(|c| self.engine.options.earlier_values && c.foreign.is_none());
        let earlier = asked.and_then(|c| earlier::value(c.name.as_str(), name.as_str()));
        let item = NewItem {
            name,
            other,
            ty,
            direction,
            initial: earlier.filter(|v| v.ty() == ty).map_or(spec.initial, |v| v.bits()),
            storage: NonNull::new(spec.storage),
            hidden: spec.flags & item_flags::HIDDEN != 0,
            times: false,
            safety: spec.flags & item_flags::SAFETY != 0,
            measured: spec.flags & item_flags::MEASURED != 0,
            doc,
        };
        let (ix, slot) = self.engine.model.new_item(owner, item)?;
        if let Some(slot) = slot {
            self.slots.insert(slot.as_ptr().addr(), ix);
        }
        Ok((ix, slot))
    }

    fn malformed(&self, why: &str) -> Error {
        let name =
            self.engine.model.graph().component(self.component).map_or("", |c| c.name.as_str());
        Error::InitFailed { name: name.into(), why: why.into(), code: Status::EINVAL.0 }
    }

    fn text<'t>(&self, s: Str) -> Result<&'t str, Error> {
        // SAFETY: the component's strings live across its call.
        unsafe { s.get() }.ok_or_else(|| self.malformed("a text is not UTF-8"))
    }

    pub(crate) fn funct(&mut self, spec: &FunctSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.malformed("a function has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("function", self.text(spec.name)?)?;
        if self.engine.model.graph().funct_named(name.as_str()).is_some() {
            return Err(Error::Duplicate { what: "function", name: name.as_str().into() });
        }
        let account = self.engine.model.new_account(self.component, &name, true)?;
        let funct = Funct {
            name: name.clone(),
            reentrant: spec.flags & funct_flags::REENTRANT != 0,
            unknown: spec.flags & funct_flags::UNKNOWN != 0,
            fast: spec.flags & funct_flags::FAST != 0,
            fp: spec.flags & funct_flags::FP != 0,
            doc: self.engine.model.doc(self.text(spec.doc)?),
            told: false,
            code: Arc::new(code),
            account,
        };
        let ix = self.engine.model.new_funct(self.component, funct);
        if let Some(c) = self.engine.model.graph().component(self.component) {
            ends::note_funct(u32::try_from(ix.index()).unwrap_or(u32::MAX), &c.name, &name);
        }
        // SAFETY: the component's list lives across its call.
        let uses = unsafe { list(spec.uses, spec.n_uses) };
        self.draw_uses(ix, uses);
        if spec.flags & funct_flags::NO_FP == 0 {
            self.engine.model.note_floats(ix);
        }
        Ok(())
    }

    pub(crate) fn thread(&mut self, spec: &ThreadSpec) -> Result<(), Error> {
        let name = Name::parse("thread", self.text(spec.name)?)?;
        let shared = self.engine.runtime.shared();
        let fp = spec.flags & thread_flags::NO_FP == 0;
        let ix = self.engine.model.new_thread(name, (spec.period_ns, fp), shared)?;
        // The thread's pseudo component is removed with this one.
        if let Some(pseudo) = self.engine.model.graph().owner_of(ix) {
            self.engine.model.connect(self.component, pseudo, Edge::Owns);
        }
        self.threads.push(ix);
        Ok(())
    }

    pub(crate) fn task(&mut self, spec: &TaskSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.malformed("a task has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("task", self.text(spec.name)?)?;
        if spec.period_ns <= 0 {
            return Err(self.malformed("a task has no period"));
        }
        let due = self.engine.runtime.now();
        let owner =
            self.engine.model.graph().component(self.component).map_or("", |c| c.name.as_str());
        let doing = Doing::new(owner, Activity::Task(name.clone()));
        let by = (self.component, doing);
        self.engine.runtime.add_task(Task::new(name, by, spec.period_ns, due, code));
        Ok(())
    }

    pub(crate) fn worker(&mut self, spec: &WorkerSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.malformed("a worker has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("worker", self.text(spec.name)?)?;
        if self.engine.workers.has(&name) {
            return Err(Error::Duplicate { what: "worker", name: name.as_str().into() });
        }
        if spec.period_ns <= 0 || spec.items == 0 {
            return Err(self.malformed("a worker has no period, or no items in a step"));
        }
        let doc = self.text(spec.doc)?.into();
        let Some(c) = self.engine.model.graph().component(self.component) else { return Ok(()) };
        let (owner, doing) =
            (c.name.clone(), Doing::new(c.name.as_str(), Activity::Worker(name.clone())));
        let (period_ns, items) = (spec.period_ns, spec.items);
        let declared = worker::Declared { name, owner, doc, period_ns, items, doing };
        self.engine.workers.add(
            self.component,
            declared,
            code,
            self.engine.runtime.shared().clone(),
        );
        Ok(())
    }

    pub(crate) fn snapshot(&mut self, spec: &SnapshotSpec) -> Result<SnapshotRef, Error> {
        let name = Name::parse("snapshot", self.text(spec.name)?)?;
        if self.engine.snapshots.has(&name) {
            return Err(Error::Duplicate { what: "snapshot", name: name.as_str().into() });
        }
        let doc = self.text(spec.doc)?;
        let Some(c) = self.engine.model.graph().component(self.component) else {
            return Err(self.malformed("a snapshot has no component"));
        };
        let snapshot = Snapshot::new((self.component, &c.name), &name, doc, spec)
            .map_err(|why| self.malformed(&why))?;
        let made = snapshot.made();
        self.engine.snapshots.add(name, snapshot);
        Ok(made)
    }

    pub(crate) fn command(&mut self, spec: &CommandSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.malformed("a command has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("command", self.text(spec.name)?)?;
        if self.engine.model.graph().commands.contains_key(&name) {
            return Err(Error::Duplicate { what: "command", name: name.as_str().into() });
        }
        let mut args = Vec::new();
        for i in 0..spec.args.len() {
            // SAFETY: the component's static list.
            let declared = unsafe { spec.args.get(i) }.and_then(|a| Declared::copy(&a));
            args.push(declared.ok_or_else(|| self.malformed("an argument is not well declared"))?);
        }
        let doc = self.text(spec.doc)?.into();
        let owner = self.engine.model.graph().component(self.component);
        let owner = owner.map_or("", |c| c.name.as_str());
        let doing = Doing::new(owner, Activity::Command(name.clone()));
        let command = Command { name, doc, args, code, doing };
        self.engine.model.new_command(self.component, command);
        Ok(())
    }

    pub(crate) fn stream(&mut self, spec: &StreamSpec) -> Result<StreamRef, Error> {
        let name = Name::parse("stream", self.text(spec.name)?)?;
        if self.engine.model.rings().contains_key(&name) {
            return Err(Error::Duplicate { what: "stream", name: name.as_str().into() });
        }
        let ring = SharedRing::new(self.component, spec).map_err(|why| self.malformed(&why))?;
        let made = ring.made();
        self.engine.model.new_ring(name, ring);
        Ok(made)
    }

    pub(crate) fn offer(&mut self, spec: &ServiceSpec) -> Result<(), Error> {
        let code = Code::new((), spec.state, spec.free, self.keep.clone());
        let name = self.text(spec.name)?;
        if let Some((by, _)) = self.engine.model.graph().service(name, None) {
            let by = self.engine.model.graph().component(by).map_or("", |c| c.name.as_str()).into();
            return Err(Error::ServiceTaken { name: name.into(), by });
        }
        // SAFETY: the component's list lives across its call.
        let uses = unsafe { list(spec.uses, spec.n_uses) }.to_vec();
        let (name, version) = (name.into(), spec.version);
        let service = Service { name, version, table: spec.table, uses, code };
        if let Some(c) = self.engine.model.component_mut(self.component) {
            c.services.push(service);
        }
        Ok(())
    }

    pub(crate) fn find(&mut self, name: Str, version: u32) -> Result<*const c_void, Error> {
        let name = self.text(name)?;
        let found = self.found(name, version).map(|found| found.table);
        found.ok_or_else(|| Error::NoService { name: name.into(), version })
    }

    /// Does the same as [`find`](Self::find), and also returns the items that the service accesses.
    /// It is not an error if there is no service of that name.
    pub(crate) fn bind(&mut self, name: Str, version: u32) -> Result<ServiceRef, Error> {
        let name = self.text(name)?;
        match self.found(name, version) {
            Some(found) => Ok(found),
            None if self.engine.model.graph().service(name, None).is_none() => {
                Ok(ServiceRef { table: core::ptr::null(), uses: core::ptr::null(), n_uses: 0 })
            }
            None => Err(Error::NoService { name: name.into(), version }),
        }
    }

    /// Finds a service, and keeps its provider loaded.
    fn found(&mut self, name: &str, version: u32) -> Option<ServiceRef> {
        let (by, service) = self.engine.model.graph().service(name, Some(version))?;
        let (uses, n_uses) = (service.uses.as_ptr(), service.uses.len());
        let found = ServiceRef { table: service.table, uses, n_uses };
        if by != self.component {
            self.engine.model.connect(self.component, by, Edge::Needs);
        }
        Some(found)
    }

    /// Notes that the component asks whether the value of one of its pins is measured.
    pub(crate) fn measured(&mut self, pin: *const Slot, into: *const Slot) -> Result<(), Error> {
        let own = |slot: *const Slot| self.slots.get(&slot.addr()).copied();
        let (Some(pin), Some(into)) = (own(pin), own(into)) else {
            return Err(self.malformed("only pins of this component can be asked about"));
        };
        self.engine.model.ask_measured(self.component, pin, into);
        Ok(())
    }

    pub(crate) fn action(&self, spec: &ActionSpec) -> Option<Code<CommandRun>> {
        let run = spec.run?;
        Some(Code::new(run, spec.state, spec.free, self.keep.clone()))
    }

    pub(crate) fn answer(&mut self, result: Result<(), Error>) -> Status {
        match result {
            Ok(()) => Status::OK,
            Err(e) => {
                let status = Status(e.errno());
                self.keep_refusal(e);
                status
            }
        }
    }
}

/// Returns a list of a component.
///
/// # Safety
/// `uses` is null, or holds `n` uses while the list is read.
const unsafe fn list<'u>(uses: *const Use, n: usize) -> &'u [Use] {
    if n == 0 || uses.is_null() {
        return &[];
    }
    // SAFETY: the caller's promise.
    unsafe { core::slice::from_raw_parts(uses, n) }
}

//! What a component may call while it is created: each call declares one thing.

use crate::{
    Engine, Error,
    args::{Args, Declared},
    code::{Code, Keep, Ptr},
    graph::{Command, Edge, Funct, Graph, Item, Ix, Node, Service, Storage},
    name::Name,
    ring::SharedRing,
    sync::Arc,
    task::Task,
    thread::Account,
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{
    ABI_MINOR, ActionSpec, ArgValue, CommandRun, CommandSpec, FunctSpec, Host, ItemSpec, Record,
    ServiceSpec, Slot, Status, Str, StreamRef, StreamSpec, TaskSpec, ThreadSpec, Use, access,
    funct_flags, host_flags, item_flags,
};
use hal_protocol::{Direction, Type};
use std::collections::BTreeMap;

/// A load in progress.
pub(crate) struct Creating<'e> {
    pub(crate) engine: &'e mut Engine,
    pub(crate) component: Ix,
    pub(crate) keep: Arc<Keep>,
    pub(crate) args: Args,
    /// Why a declaration was refused.
    pub(crate) refused: Option<Error>,
    /// What the component said of its failure.
    pub(crate) failed: Option<String>,
    pub(crate) opens: Vec<Code<CommandRun>>,
    pub(crate) threads: Vec<Ix>,
    /// Slots of this load, for the uses of functions.
    slots: BTreeMap<usize, Ix>,
    /// Who gives and takes hidden state.
    hidden: Vec<(Ix, u64, u32)>,
    created: BTreeMap<Ix, Vec<Use>>,
}

impl<'e> Creating<'e> {
    pub(crate) const fn new(
        engine: &'e mut Engine,
        component: Ix,
        keep: Arc<Keep>,
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
            created: BTreeMap::new(),
        }
    }

    /// The record for one instance.
    pub(crate) fn host(
        &mut self,
        prefix: &str,
        index: u32,
        personality: i64,
        private: bool,
    ) -> Host {
        let mut flags = self.keep.calls().flags;
        if self.engine.options.simulate {
            flags |= host_flags::SIMULATED;
        }
        if private {
            flags |= host_flags::PRIVATE;
        }
        Host {
            size: hal_abi::size::<Host>(),
            abi_minor: ABI_MINOR,
            flags,
            index,
            personality,
            prefix: Str::borrow(prefix),
            ctx: (&raw mut *self).cast(),
            calls: std::ptr::from_ref(self.keep.calls()),
            fail: Some(fail),
            arg: Some(arg),
            item: Some(item),
            funct: Some(funct),
            thread: Some(thread),
            task: Some(task),
            command: Some(command),
            open: Some(open),
            stop: Some(stop),
            stream: Some(stream),
            offer: Some(offer),
            find: Some(find),
        }
    }

    /// Draws the edges of what functions touch, when all of the load is declared.
    pub(crate) fn draw_edges(&mut self) {
        for (funct, uses) in core::mem::take(&mut self.created) {
            for u in uses {
                if u.slot.is_null() {
                    self.hidden.push((funct, u.token, u.access));
                    continue;
                }
                let at = self.slots.get(&u.slot.addr()).copied();
                let Some(item) = at.or_else(|| self.engine.item_at(u.slot)) else { continue };
                let g = &mut self.engine.graph.g;
                if u.access & access::READ != 0 {
                    g.add_edge(item, funct, Edge::Reads);
                }
                if u.access & access::WRITE != 0 {
                    g.add_edge(funct, item, Edge::Writes);
                }
            }
        }
        let hidden = core::mem::take(&mut self.hidden);
        for (giver, token, _) in hidden.iter().filter(|h| h.2 & access::WRITE != 0) {
            for (taker, ..) in hidden.iter().filter(|h| h.1 == *token && h.2 & access::READ != 0) {
                if giver != taker {
                    self.engine.graph.g.add_edge(*giver, *taker, Edge::HandsOver);
                }
            }
        }
    }

    fn item(&mut self, spec: &ItemSpec) -> Result<Option<NonNull<Slot>>, Error> {
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
            return Err(self.odd("an item has no known type or direction"));
        };
        let (name, old) = (self.text(spec.name)?, self.text(spec.old_name)?);
        let doc = self.text(spec.doc)?;
        let what = if direction.is_pin() { "pin" } else { "parameter" };
        let (name, other) = match (old.is_empty(), self.engine.options.old_names) {
            (false, true) => (Name::parse(what, old)?, Some(Name::parse(what, name)?)),
            _ => (Name::parse(what, name)?, None),
        };
        let doc = self.engine.graph.doc(doc);
        let item = NewItem {
            name,
            other,
            ty,
            direction,
            initial: spec.initial,
            storage: NonNull::new(spec.storage),
            hidden: spec.flags & item_flags::HIDDEN != 0,
            times: false,
            doc,
        };
        let (ix, slot) = self.engine.new_item(self.component, item)?;
        if let Some(slot) = slot {
            self.slots.insert(slot.as_ptr().addr(), ix);
        }
        Ok(slot)
    }

    fn odd(&self, why: &str) -> Error {
        let name = self.engine.graph.component(self.component).map_or("", |c| c.name.as_str());
        Error::InitFailed { name: name.into(), why: why.into(), code: Status::EINVAL.0 }
    }

    fn text<'t>(&self, s: Str) -> Result<&'t str, Error> {
        // SAFETY: the component's strings live across its call.
        unsafe { s.get() }.ok_or_else(|| self.odd("a text is not UTF-8"))
    }

    fn funct(&mut self, spec: &FunctSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.odd("a function has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("function", self.text(spec.name)?)?;
        if self.engine.graph.functs.contains_key(&name) {
            return Err(Error::Duplicate { what: "function", name: name.as_str().into() });
        }
        let account = self.engine.new_account(self.component, &name, true)?;
        let funct = Funct {
            name: name.clone(),
            reentrant: spec.flags & funct_flags::REENTRANT != 0,
            code: Arc::new(code),
            account,
            users: 0,
        };
        let ix = self.engine.graph.g.add_node(Node::Funct(funct));
        self.engine.graph.g.add_edge(self.component, ix, Edge::Owns);
        self.engine.graph.functs.insert(name, ix);
        if spec.n_uses > 0 && !spec.uses.is_null() {
            // SAFETY: the component's list lives across its call.
            let uses = unsafe { core::slice::from_raw_parts(spec.uses, spec.n_uses) };
            self.created.insert(ix, uses.to_vec());
        }
        Ok(())
    }

    fn thread(&mut self, spec: &ThreadSpec) -> Result<(), Error> {
        let name = Name::parse("thread", self.text(spec.name)?)?;
        let ix = self.engine.new_thread(name, spec.period_ns)?;
        self.threads.push(ix);
        Ok(())
    }

    fn task(&mut self, spec: &TaskSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.odd("a task has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("task", self.text(spec.name)?)?;
        if spec.period_ns <= 0 {
            return Err(self.odd("a task has no period"));
        }
        let due = self.engine.shared.now();
        self.engine.tasks.push(Task::new(name, self.component, spec.period_ns, due, code));
        Ok(())
    }

    fn command(&mut self, spec: &CommandSpec) -> Result<(), Error> {
        let Some(run) = spec.run else { return Err(self.odd("a command has no code")) };
        let code = Code::new(run, spec.state, spec.free, self.keep.clone());
        let name = Name::parse("command", self.text(spec.name)?)?;
        if self.engine.graph.commands.contains_key(&name) {
            return Err(Error::Duplicate { what: "command", name: name.as_str().into() });
        }
        let mut args = Vec::new();
        for i in 0..spec.args.len() {
            // SAFETY: the component's static list.
            let declared = unsafe { spec.args.get(i) }.and_then(|a| Declared::copy(&a));
            args.push(declared.ok_or_else(|| self.odd("an argument is not well declared"))?);
        }
        let doc = self.text(spec.doc)?.into();
        self.engine.graph.commands.insert(name.clone(), self.component);
        if let Some(c) = self.engine.graph.component_mut(self.component) {
            c.commands.push(Command { name, doc, args, code });
        }
        Ok(())
    }

    fn stream(&mut self, spec: &StreamSpec) -> Result<StreamRef, Error> {
        let name = Name::parse("stream", self.text(spec.name)?)?;
        if self.engine.rings.contains_key(&name) {
            return Err(Error::Duplicate { what: "stream", name: name.as_str().into() });
        }
        let ring = SharedRing::new(self.component, spec).map_err(|why| self.odd(&why))?;
        let made = ring.made();
        self.engine.rings.insert(name, ring);
        Ok(made)
    }

    fn offer(&mut self, spec: &ServiceSpec) -> Result<(), Error> {
        let code = Code::new((), spec.state, spec.free, self.keep.clone());
        let name = self.text(spec.name)?;
        if let Some((by, _)) = self.engine.graph.service(name, None) {
            let by = self.engine.graph.component(by).map_or("", |c| c.name.as_str()).into();
            return Err(Error::ServiceTaken { name: name.into(), by });
        }
        let service = Service { name: name.into(), version: spec.version, table: spec.table, code };
        if let Some(c) = self.engine.graph.component_mut(self.component) {
            c.services.push(service);
        }
        Ok(())
    }

    fn find(&mut self, name: Str, version: u32) -> Result<*const c_void, Error> {
        let name = self.text(name)?;
        let (by, table) = self
            .engine
            .graph
            .service(name, Some(version))
            .ok_or_else(|| Error::NoService { name: name.into(), version })?;
        if by != self.component {
            self.engine.graph.g.add_edge(self.component, by, Edge::Needs);
        }
        Ok(table)
    }

    fn action(&self, spec: &ActionSpec) -> Option<Code<CommandRun>> {
        let run = spec.run?;
        Some(Code::new(run, spec.state, spec.free, self.keep.clone()))
    }

    fn answer(&mut self, result: Result<(), Error>) -> Status {
        match result {
            Ok(()) => Status::OK,
            Err(e) => {
                let status = Status(e.errno());
                self.refused.get_or_insert(e);
                status
            }
        }
    }
}

impl Graph {
    /// Who offers a service, and its table.
    pub(crate) fn service(&self, name: &str, version: Option<u32>) -> Option<(Ix, *const c_void)> {
        self.components.values().find_map(|ix| {
            let service = self
                .component(*ix)?
                .services
                .iter()
                .find(|s| &*s.name == name && version.is_none_or(|v| v == s.version))?;
            Some((*ix, service.table))
        })
    }
}

/// A pin or parameter to be made.
pub(crate) struct NewItem {
    pub(crate) name: Name,
    pub(crate) other: Option<Name>,
    pub(crate) ty: Type,
    pub(crate) direction: Direction,
    pub(crate) initial: u64,
    pub(crate) storage: Option<NonNull<c_void>>,
    pub(crate) hidden: bool,
    pub(crate) times: bool,
    pub(crate) doc: Arc<str>,
}

impl Engine {
    /// Makes a pin or parameter. One with storage of its own has no slot.
    pub(crate) fn new_item(
        &mut self,
        owner: Ix,
        new: NewItem,
    ) -> Result<(Ix, Option<NonNull<Slot>>), Error> {
        let param = !new.direction.is_pin();
        let what = if param { "parameter" } else { "pin" };
        let names = self.graph.names(param);
        for name in [Some(&new.name), new.other.as_ref()].into_iter().flatten() {
            if names.contains_key(name) {
                return Err(Error::Duplicate { what, name: name.as_str().into() });
            }
        }
        let (storage, slot) = match new.storage {
            Some(own) if param => (Storage::Own(own), None),
            _ => {
                let slot = self.arena.slot(new.initial)?;
                (Storage::Slot(Ptr(slot)), Some(slot))
            }
        };
        let (name, other) = (new.name.clone(), new.other.clone());
        let item = Item {
            name: new.name,
            other: new.other,
            alias: None,
            ty: new.ty,
            direction: new.direction,
            storage,
            hidden: new.hidden,
            times: new.times,
            doc: new.doc,
        };
        let ix = self.graph.g.add_node(Node::Item(item));
        self.graph.g.add_edge(owner, ix, Edge::Owns);
        let names = self.graph.names_mut(param);
        names.insert(name, ix);
        if let Some(other) = other {
            names.insert(other, ix);
        }
        if param {
            self.counts.params += 1;
        } else {
            self.counts.pins += 1;
        }
        Ok((ix, slot))
    }

    /// Makes the pins and parameters that show times of a function or thread.
    pub(crate) fn new_account(
        &mut self,
        owner: Ix,
        name: &Name,
        funct: bool,
    ) -> Result<Account, Error> {
        let mut add = |suffix: &str, ty, direction, doc: &str| {
            let what = if direction == Direction::Out { "pin" } else { "parameter" };
            let name = Name::parse(what, &format!("{name}.{suffix}"))?;
            let doc = self.graph.doc(doc);
            let new = NewItem {
                name,
                other: None,
                ty,
                direction,
                initial: 0,
                storage: None,
                hidden: false,
                times: true,
                doc,
            };
            let (_, slot) = self.new_item(owner, new)?;
            slot.map(Ptr).ok_or(Error::OutOfMemory)
        };
        let time = add("time", Type::S32, Direction::Out, "Last run time, in ns.")?;
        let tmax =
            add("tmax", Type::S32, Direction::Rw, "Longest run time, in ns; write 0 to reset.")?;
        let increased = if funct {
            let doc = "Whether the longest run time grew in the last run.";
            Some(add("tmax-increased", Type::Bit, Direction::Ro, doc)?)
        } else {
            None
        };
        Ok(Account { time, tmax, increased })
    }

    /// The item of a slot that belongs to another component.
    fn item_at(&self, slot: *const Slot) -> Option<Ix> {
        let all = self.graph.pins.values().chain(self.graph.params.values());
        all.copied().find(|ix| {
            self.graph
                .item(*ix)
                .and_then(Item::slot)
                .is_some_and(|s| s.as_ptr().cast_const() == slot)
        })
    }
}

fn creating<'c>(ctx: *mut c_void) -> &'c mut Creating<'c> {
    // SAFETY: the `Creating` of the load in progress; components call back on this thread only.
    unsafe { &mut *ctx.cast::<Creating<'c>>() }
}

macro_rules! declare {
    ($(#[$m:meta])* $name:ident, $spec:ty, |$c:ident, $s:ident| $body:expr) => {
        $(#[$m])*
        /// # Safety
        /// Called by a component during `create` with the context and records of that call.
        unsafe extern "C" fn $name(ctx: *mut c_void, spec: *const $spec) -> Status {
            let $c = creating(ctx);
            // SAFETY: the component's record lives across its call.
            let read = unsafe { <$spec>::read(spec) };
            let Some($s) = read else { return Status::EINVAL };
            let result: Result<(), Error> = $body;
            $c.answer(result)
        }
    };
}

declare!(funct, FunctSpec, |c, s| c.funct(&s));
declare!(thread, ThreadSpec, |c, s| c.thread(&s));
declare!(task, TaskSpec, |c, s| c.task(&s));
declare!(command, CommandSpec, |c, s| c.command(&s));
declare!(offer, ServiceSpec, |c, s| c.offer(&s));
declare!(open, ActionSpec, |c, s| {
    let code = c.action(&s);
    c.opens.extend(code);
    Ok(())
});
declare!(stop, ActionSpec, |c, s| {
    let code = c.action(&s);
    if let Some(component) = c.engine.graph.component_mut(c.component) {
        component.stops.extend(code);
    }
    Ok(())
});

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn fail(ctx: *mut c_void, text: Str) {
    let c = creating(ctx);
    // SAFETY: the component's text lives across its call.
    c.failed = Some(unsafe { text.get() }.unwrap_or("failed").to_owned());
}

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn arg(ctx: *mut c_void, name: Str, out: *mut ArgValue) -> Status {
    let c = creating(ctx);
    // SAFETY: the component's text lives across its call.
    let value = c.args.get(unsafe { name.get() }.unwrap_or_default());
    // SAFETY: a live place of the component's.
    unsafe { out.write(value) };
    Status::OK
}

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn item(
    ctx: *mut c_void,
    spec: *const ItemSpec,
    out: *mut *const Slot,
) -> Status {
    let c = creating(ctx);
    // SAFETY: the component's record lives across its call.
    let Some(s) = (unsafe { ItemSpec::read(spec) }) else { return Status::EINVAL };
    let made = c.item(&s).map(|slot| {
        // SAFETY: a live place of the component's.
        unsafe { out.write(slot.map_or(core::ptr::null(), |s| s.as_ptr().cast_const())) };
    });
    c.answer(made)
}

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn stream(
    ctx: *mut c_void,
    spec: *const StreamSpec,
    out: *mut StreamRef,
) -> Status {
    let c = creating(ctx);
    // SAFETY: the component's record lives across its call.
    let Some(s) = (unsafe { StreamSpec::read(spec) }) else { return Status::EINVAL };
    let made = c.stream(&s).map(|made| {
        // SAFETY: a live place of the component's.
        unsafe { out.write(made) };
    });
    c.answer(made)
}

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn find(
    ctx: *mut c_void,
    name: Str,
    version: u32,
    out: *mut *const c_void,
) -> Status {
    let c = creating(ctx);
    let found = c.find(name, version).map(|table| {
        // SAFETY: a live place of the component's.
        unsafe { out.write(table) };
    });
    c.answer(found)
}

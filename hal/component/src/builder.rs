//! How one instance declares itself to the engine.

use crate::{
    Call, Clock, Field, Gives, In, Item, Kinematics, KinematicsRef, Messages, Receiver, Sender,
    StreamIn, StreamOut, Takes, Touch, Update, Uses, Value,
    abi::{
        self, ActionSpec, ArgSpec, ArgValue, CommandSpec, FunctSpec, Host, ItemSpec, Status, Str,
        StreamSpec, TaskSpec, ThreadSpec, component_flags, funct_flags, host_flags, item_flags,
    },
    call::read_arg,
    item::Dir,
    kinematics, shim,
};
use core::{ffi::c_void, ptr::NonNull};
use crossbeam::queue::ArrayQueue;
use std::{borrow::Cow, sync::Arc};

/// Why an instance could not be made, or a command not carried out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    pub(crate) status: Status,
    pub(crate) text: Option<Cow<'static, str>>,
}

impl Error {
    /// An error in the user's words: lower case, no full stop.
    pub fn new(text: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::EINVAL, text: Some(text.into()) }
    }

    /// The sentence, if it has one of its own; otherwise the engine said why.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        self.text.as_deref()
    }

    pub(crate) const fn engine(status: Status) -> Self {
        Self { status, text: None }
    }
}

/// How an item is declared.
#[derive(Clone, Copy, Debug)]
pub struct Decl<'a> {
    name: &'a str,
    doc: &'a str,
    old: &'a str,
    flags: u32,
}

impl<'a> Decl<'a> {
    /// A name within the instance (absolute for a type created once) and its documentation:
    /// one line with unit and range.
    #[must_use]
    pub const fn new(name: &'a str, doc: &'a str) -> Self {
        Self { name, doc, old: "", flags: 0 }
    }

    /// The absolute name it had before joints and axes were told apart.
    #[must_use]
    pub const fn old(mut self, name: &'a str) -> Self {
        self.old = name;
        self
    }

    /// A bit of simulated hardware: listed only when a pattern names it.
    #[must_use]
    pub const fn hidden(mut self) -> Self {
        self.flags |= item_flags::HIDDEN;
        self
    }

    /// A limit switch or e-stop input.
    #[must_use]
    pub const fn safety(mut self) -> Self {
        self.flags |= item_flags::SAFETY;
        self
    }
}

impl Decl<'static> {
    /// The declaration as a library shows it without running code: a line of
    /// [`Component::ITEMS`](crate::Component::ITEMS). `initial` is the first value as stored,
    /// such as `1.5_f64.to_bits()`.
    #[must_use]
    pub const fn spec<F: Field>(self, initial: u64) -> ItemSpec {
        ItemSpec {
            size: abi::size::<ItemSpec>(),
            flags: self.flags,
            name: Str::new(self.name),
            doc: Str::new(self.doc),
            old_name: Str::new(self.old),
            initial,
            storage: core::ptr::null_mut(),
            ty: F::TYPE,
            dir: F::DIR,
        }
    }
}

/// Declares one instance.
#[derive(Debug)]
pub struct Builder<'h> {
    host: &'h Host,
    once: bool,
    /// Uses of services found so far: every function declared afterwards takes them over.
    pub(crate) borrowed: Vec<abi::Use>,
}

impl<'h> Builder<'h> {
    pub(crate) const fn new(host: &'h Host, flags: u32) -> Self {
        Self { host, once: flags & component_flags::ONCE != 0, borrowed: Vec::new() }
    }

    /// The name of this instance, such as `and2.0`.
    #[must_use]
    pub fn prefix(&self) -> &str {
        // SAFETY: live while `create` runs.
        unsafe { self.host.prefix.get() }.unwrap_or_default()
    }

    /// The number of this instance, from zero.
    #[must_use]
    pub const fn index(&self) -> u32 {
        self.host.index
    }

    /// The personality of this instance, zero when none was given.
    #[must_use]
    pub const fn personality(&self) -> i64 {
        self.host.personality
    }

    /// Whether hardware is simulated: a driver then works on a register file whose bits are pins.
    #[must_use]
    pub const fn is_simulated(&self) -> bool {
        self.host.flags & host_flags::SIMULATED != 0
    }

    /// What speaks for the component while it runs.
    #[must_use]
    pub fn messages(&self) -> Messages {
        Messages(self.calls())
    }

    /// The machine's clock.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock(self.calls())
    }

    fn calls(&self) -> &'static abi::CallHost {
        // SAFETY: the engine keeps the record until the component is unloaded.
        unsafe { &*self.host.calls }
    }

    fn value(&self, name: &str) -> Option<ArgValue> {
        let arg = self.host.arg?;
        // SAFETY: the engine's function; the pointers live across the call.
        read_arg(|out| unsafe { arg(self.host.ctx, Str::borrow(name), out) })
    }

    /// An integer or truth value that was given or has a default.
    #[must_use]
    pub fn arg_int(&self, name: &str) -> Option<i64> {
        self.value(name).map(|v| v.int)
    }

    /// A floating-point number that was given or has a default.
    #[must_use]
    pub fn arg_float(&self, name: &str) -> Option<f64> {
        self.value(name).map(|v| v.float)
    }

    /// A string that was given or has a default.
    #[must_use]
    pub fn arg_text(&self, name: &str) -> Option<String> {
        // SAFETY: the engine keeps the string until `create` returns.
        self.value(name).and_then(|v| unsafe { v.text.get() }.map(str::to_owned))
    }

    /// A list of integers; empty when it was not given and has no default.
    #[must_use]
    pub fn arg_ints(&self, name: &str) -> Vec<i64> {
        let Some(v) = self.value(name).filter(|v| !v.ints.is_null()) else { return Vec::new() };
        // SAFETY: the engine keeps the list until `create` returns.
        unsafe { core::slice::from_raw_parts(v.ints, v.len) }.to_vec()
    }

    /// A list of strings; empty when it was not given and has no default.
    #[must_use]
    pub fn arg_texts(&self, name: &str) -> Vec<String> {
        let Some(v) = self.value(name).filter(|v| !v.texts.is_null()) else { return Vec::new() };
        // SAFETY: the engine keeps the list until `create` returns.
        let list = unsafe { core::slice::from_raw_parts(v.texts, v.len) };
        // SAFETY: as for the list.
        list.iter().map(|s| unsafe { s.get() }.unwrap_or_default().to_owned()).collect()
    }

    fn full<'n>(&self, name: &'n str) -> Cow<'n, str> {
        match (self.once, name.is_empty()) {
            (true, false) => Cow::Borrowed(name),
            (_, true) => Cow::Owned(self.prefix().to_owned()),
            (false, false) => Cow::Owned(format!("{}.{name}", self.prefix())),
        }
    }

    /// Adds a pin or parameter; direction and type come from the handle's type.
    ///
    /// # Errors
    /// The name is taken or too long, or memory is out.
    pub fn item<T: Value, D: Dir>(
        &mut self,
        name: &str,
        doc: &str,
        initial: T,
    ) -> Result<Item<T, D>, Error> {
        self.declare(Decl::new(name, doc), initial)
    }

    /// Adds a pin or parameter that is declared at length.
    ///
    /// # Errors
    /// As [`Self::item`].
    pub fn declare<T: Value, D: Dir>(
        &mut self,
        decl: Decl<'_>,
        initial: T,
    ) -> Result<Item<T, D>, Error> {
        let name = self.full(decl.name);
        let spec = ItemSpec {
            size: abi::size::<ItemSpec>(),
            flags: decl.flags,
            name: Str::borrow(&name),
            doc: Str::borrow(decl.doc),
            old_name: Str::borrow(decl.old),
            initial: initial.to_bits(),
            storage: core::ptr::null_mut(),
            ty: T::TYPE,
            dir: D::CODE,
        };
        let mut slot = core::ptr::null();
        let item = self.host.item.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; `spec` and `slot` live across the call.
        check(unsafe { item(self.host.ctx, &raw const spec, &raw mut slot) })?;
        NonNull::new(slot.cast_mut()).map(Item::from_slot).ok_or(Error::engine(Status::EINVAL))
    }

    fn uses(&self, what: &impl Touch) -> Vec<abi::Use> {
        let mut uses = Uses(self.borrowed.clone());
        what.touch(&mut uses);
        uses.0
    }

    /// Exports a function; an empty name is the instance's own name.
    ///
    /// # Errors
    /// The name is taken or too long.
    pub fn function<F: Update>(&mut self, name: &str, doc: &str, f: F) -> Result<(), Error> {
        self.function_with(name, doc, 0, f)
    }

    /// Exports a function that belongs in a fast thread.
    ///
    /// # Errors
    /// The name is taken or too long.
    pub fn fast_function<F: Update>(&mut self, name: &str, doc: &str, f: F) -> Result<(), Error> {
        self.function_with(name, doc, funct_flags::FAST, f)
    }

    fn function_with<F: Update>(
        &mut self,
        name: &str,
        doc: &str,
        flags: u32,
        f: F,
    ) -> Result<(), Error> {
        let name = self.full(name);
        let uses = self.uses(&f);
        let spec = FunctSpec {
            size: abi::size::<FunctSpec>(),
            flags,
            name: Str::borrow(&name),
            doc: Str::borrow(doc),
            run: Some(shim::run::<F>),
            state: shim::give(shim::Running::new(f, self.calls())),
            free: Some(shim::free::<shim::Running<F>>),
            uses: uses.as_ptr(),
            n_uses: uses.len(),
        };
        let funct = self.host.funct.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; ownership of the state passes with the call.
        check(unsafe { funct(self.host.ctx, &raw const spec) })
    }

    /// Declares background work, done every `period_ns` of machine time, never in a realtime
    /// thread.
    ///
    /// # Errors
    /// The name is taken or too long.
    pub fn task<F: Update>(
        &mut self,
        name: &str,
        doc: &str,
        period_ns: i64,
        f: F,
    ) -> Result<(), Error> {
        let name = self.full(name);
        let uses = self.uses(&f);
        let spec = TaskSpec {
            size: abi::size::<TaskSpec>(),
            flags: 0,
            name: Str::borrow(&name),
            doc: Str::borrow(doc),
            period_ns,
            run: Some(shim::run::<F>),
            state: shim::give(shim::Running::new(f, self.calls())),
            free: Some(shim::free::<shim::Running<F>>),
            uses: uses.as_ptr(),
            n_uses: uses.len(),
        };
        let task = self.host.task.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; ownership of the state passes with the call.
        check(unsafe { task(self.host.ctx, &raw const spec) })
    }

    /// Creates a thread.
    ///
    /// # Errors
    /// The name is taken, or the period is shorter than that of an existing thread.
    pub fn thread(&mut self, name: &str, period_ns: i64) -> Result<(), Error> {
        let spec = ThreadSpec {
            size: abi::size::<ThreadSpec>(),
            flags: 0,
            name: Str::borrow(name),
            period_ns,
        };
        let thread = self.host.thread.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; `spec` lives across the call.
        check(unsafe { thread(self.host.ctx, &raw const spec) })
    }

    /// Declares a command for users, `NAME name=value …`; the name is absolute, such as
    /// `motion.jog`. It runs on the control side.
    ///
    /// # Errors
    /// The name is taken or too long.
    pub fn command<F>(
        &mut self,
        name: &str,
        doc: &str,
        args: &'static [&'static ArgSpec],
        f: F,
    ) -> Result<(), Error>
    where
        F: FnMut(&Call<'_>) -> Result<(), Error> + Send + 'static,
    {
        let spec = CommandSpec {
            size: abi::size::<CommandSpec>(),
            flags: 0,
            name: Str::borrow(name),
            doc: Str::borrow(doc),
            args: abi::List::new(args),
            run: Some(shim::call::<F>),
            state: shim::give(f),
            free: Some(shim::free::<F>),
        };
        let command = self.host.command.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; ownership of the state passes with the call.
        check(unsafe { command(self.host.ctx, &raw const spec) })
    }

    /// Declares what touches the outside world first. It runs after everything was created, and
    /// never for `check`; when it fails, the load fails.
    ///
    /// # Errors
    /// What the engine refused.
    pub fn on_open<F>(&mut self, f: F) -> Result<(), Error>
    where
        F: FnMut(&Call<'_>) -> Result<(), Error> + Send + 'static,
    {
        self.action(self.host.open, f)
    }

    /// Declares what drives the outputs to their safe levels: lock-free and idempotent, and it
    /// makes the driver write everything again after a restart.
    ///
    /// # Errors
    /// What the engine refused.
    pub fn on_stop<F>(&mut self, mut f: F) -> Result<(), Error>
    where
        F: FnMut() + Send + 'static,
    {
        self.action(self.host.stop, move |_: &Call<'_>| {
            f();
            Ok(())
        })
    }

    fn action<F>(&self, to: Option<Act>, f: F) -> Result<(), Error>
    where
        F: FnMut(&Call<'_>) -> Result<(), Error> + Send + 'static,
    {
        let spec = ActionSpec {
            size: abi::size::<ActionSpec>(),
            flags: 0,
            run: Some(shim::call::<F>),
            state: shim::give(f),
            free: Some(shim::free::<F>),
        };
        let to = to.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; ownership of the state passes with the call.
        check(unsafe { to(self.host.ctx, &raw const spec) })
    }

    fn ring(
        &mut self,
        name: &str,
        direction: u32,
        depth: u32,
        types: &[u8],
    ) -> Result<Ring, Error> {
        let name = self.full(name);
        let mut padded = [0; 24];
        for (to, from) in padded.iter_mut().zip(types) {
            *to = *from;
        }
        let spec = StreamSpec {
            size: abi::size::<StreamSpec>(),
            direction,
            name: Str::borrow(&name),
            depth,
            width: u32::try_from(types.len()).unwrap_or(u32::MAX),
            types: padded,
        };
        let mut out = Ring { ring: core::ptr::null(), depth: 0, width: 0 };
        let stream = self.host.stream.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; `spec` and `out` live across the call.
        check(unsafe { stream(self.host.ctx, &raw const spec, &raw mut out) })?;
        if out.ring.is_null() { Err(Error::engine(Status::ENOMEM)) } else { Ok(out) }
    }

    /// Makes a ring that the component writes and a program reads. `types` are the type codes of
    /// the values of a record, at most [`abi::MAX_WIDTH`].
    ///
    /// # Errors
    /// The name is taken, the shape is impossible, or memory is out.
    pub fn stream_out(&mut self, name: &str, depth: u32, types: &[u8]) -> Result<StreamOut, Error> {
        let r = self.ring(name, abi::stream_direction::OUT, depth, types)?;
        // SAFETY: the engine made the ring of this shape for this component alone.
        Ok(StreamOut(unsafe { abi::Producer::new(r.ring, r.depth, r.width) }))
    }

    /// Makes a ring that a program writes and the component reads.
    ///
    /// # Errors
    /// As [`Self::stream_out`].
    pub fn stream_in(&mut self, name: &str, depth: u32, types: &[u8]) -> Result<StreamIn, Error> {
        let r = self.ring(name, abi::stream_direction::IN, depth, types)?;
        // SAFETY: the engine made the ring of this shape for this component alone.
        Ok(StreamIn(unsafe { abi::Consumer::new(r.ring, r.depth, r.width) }))
    }

    /// State (atomics) that one function hands to others: the ends say who gives and who takes.
    #[must_use]
    pub fn shared<T: Send + Sync>(&mut self, state: T) -> (Gives<T>, Takes<T>) {
        let state = Arc::new(state);
        (Gives(state.clone()), Takes(state))
    }

    /// A bounded queue of `room` values, from a command or task to a function or back.
    #[must_use]
    pub fn queue<T: Copy + Send>(&mut self, room: usize) -> (Sender<T>, Receiver<T>) {
        let queue = Arc::new(ArrayQueue::new(if room == 0 { 1 } else { room }));
        (Sender(queue.clone()), Receiver(queue))
    }

    /// Offers kinematics to other plugins.
    ///
    /// # Errors
    /// Kinematics are loaded already.
    pub fn offer_kinematics<K: Kinematics>(&mut self, k: K) -> Result<(), Error> {
        let uses = self.uses(&k);
        let spec = kinematics::offer(k, &uses);
        let offer = self.host.offer.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: the engine's function; ownership of the state passes with the call.
        check(unsafe { offer(self.host.ctx, &raw const spec) })
    }

    /// The kinematics that are loaded; functions declared afterwards take over what they touch.
    ///
    /// # Errors
    /// None are loaded.
    pub fn kinematics(&mut self) -> Result<KinematicsRef, Error> {
        let find = self.host.find.ok_or(Error::engine(Status::EINVAL))?;
        let mut table: *const c_void = core::ptr::null();
        // SAFETY: the engine's function; `table` lives across the call.
        check(unsafe {
            find(self.host.ctx, Str::new(kinematics::NAME), kinematics::VERSION, &raw mut table)
        })?;
        // SAFETY: the engine found a table of this name and version.
        unsafe { kinematics::found(table) }.ok_or(Error::engine(Status::EINVAL))
    }
}

type Act = unsafe extern "C" fn(*mut c_void, *const ActionSpec) -> Status;
type Ring = abi::StreamRef;

fn check(status: Status) -> Result<(), Error> {
    if status.is_ok() { Ok(()) } else { Err(Error::engine(status)) }
}

const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<In<bool>>();
};

//! How one instance declares itself to the engine.

use crate::{
    Call, Clock, Decl, Error, In, Item, Messages, Touch, Update, Uses, Value,
    abi::{
        self, ActionSpec, ArgSpec, ArgValue, CommandSpec, FunctSpec, Host, ItemSpec, Status, Str,
        TaskSpec, ThreadSpec, component_flags, funct_flags, host_flags,
    },
    call::read_arg,
    item::Dir,
    shim,
};
use core::{ffi::c_void, ptr::NonNull};
use std::borrow::Cow;

/// Declares one instance.
#[derive(Debug)]
pub struct Builder<'h> {
    pub(crate) host: &'h Host,
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
        self.texts(name).iter().map(owned).collect()
    }

    /// One of a list of strings, from zero, if there are so many.
    #[must_use]
    pub fn arg_text_at(&self, name: &str, at: usize) -> Option<String> {
        self.texts(name).get(at).map(owned)
    }

    fn texts(&self, name: &str) -> &[Str] {
        let Some(v) = self.value(name).filter(|v| !v.texts.is_null()) else { return &[] };
        // SAFETY: the engine keeps the list until `create` returns.
        unsafe { core::slice::from_raw_parts(v.texts, v.len) }
    }

    pub(crate) fn full<'n>(&self, name: &'n str) -> Cow<'n, str> {
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

    pub(crate) fn uses(&self, what: &impl Touch) -> Vec<abi::Use> {
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
}

fn owned(text: &Str) -> String {
    // SAFETY: the engine keeps the strings of a list until `create` returns.
    unsafe { text.get() }.unwrap_or_default().to_owned()
}

type Act = unsafe extern "C" fn(*mut c_void, *const ActionSpec) -> Status;

pub(crate) fn check(status: Status) -> Result<(), Error> {
    if status.is_ok() { Ok(()) } else { Err(Error::engine(status)) }
}

const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<In<bool>>();
};

//! Declaration of a component instance to the engine.

use crate::{
    Call, Clock, Decl, Error, HalValues, Hardware, In, Item, Messages, Touch, Update, Uses, Value,
    abi::{
        self, ActionSpec, ArgSpec, ArgValue, CommandSpec, FunctSpec, Host, ItemSpec, Status, Str,
        TaskSpec, ThreadSpec, component_flags, funct_flags, host_flags, thread_flags,
    },
    call::read_arg,
    item::Dir,
    shim,
};
use core::{ffi::c_void, ptr::NonNull};
use std::borrow::Cow;

/// Builder through which an instance declares its pins, functions, tasks and commands.
#[derive(Debug)]
pub struct Builder<'h> {
    pub(crate) host: &'h Host,
    once: bool,
    /// Uses of services found so far. Every function declared afterwards inherits them.
    pub(crate) borrowed: Vec<abi::Use>,
}

impl<'h> Builder<'h> {
    pub(crate) const fn new(host: &'h Host, flags: u32) -> Self {
        Self { host, once: flags & component_flags::ONCE != 0, borrowed: Vec::new() }
    }

    /// Returns the name of this instance, such as `and2.0`.
    #[must_use]
    pub fn prefix(&self) -> &str {
        // SAFETY: the engine keeps the name while `create` runs.
        unsafe { self.host.prefix.get() }.unwrap_or_default()
    }

    /// Returns the number of this instance, from zero.
    #[must_use]
    pub const fn index(&self) -> u32 {
        self.host.index
    }

    /// Returns the personality of this instance, or zero if none was given.
    #[must_use]
    pub const fn personality(&self) -> i64 {
        self.host.personality
    }

    /// Returns whether hardware is simulated. A driver then works on a register file whose bits are
    /// pins.
    #[must_use]
    pub const fn is_simulated(&self) -> bool {
        self.host.flags & host_flags::SIMULATED != 0
    }

    /// Returns whether the instance is only checked. A driver that asks its hardware for its pins then assumes some.
    #[must_use]
    pub const fn is_trial(&self) -> bool {
        self.host.flags & host_flags::TRIAL != 0
    }

    /// Returns the message log that the component uses while it runs.
    #[must_use]
    pub fn messages(&self) -> Messages {
        Messages(self.calls())
    }

    /// Returns the machine's clock.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock(self.calls())
    }

    /// Returns one part of the driver's hardware, which works.
    #[must_use]
    pub fn hardware(&self) -> Hardware {
        Hardware::new(self.calls())
    }

    /// Returns the values of pins, parameters and signals, for a worker.
    #[must_use]
    pub fn values(&self) -> HalValues {
        HalValues(self.calls())
    }

    pub(crate) fn calls(&self) -> &'static abi::CallHost {
        // SAFETY: the engine keeps the record until the component is unloaded.
        unsafe { &*self.host.calls }
    }

    fn value(&self, name: &str) -> Option<ArgValue> {
        let arg = self.host.arg?;
        // SAFETY: this is the engine's function; the pointers live for the duration of the call.
        read_arg(|out| unsafe { arg(self.host.ctx, Str::borrow(name), out) })
    }

    /// Returns an integer or boolean argument that was given or has a default.
    #[must_use]
    pub fn arg_int(&self, name: &str) -> Option<i64> {
        self.value(name).map(|v| v.int)
    }

    /// Returns a floating-point argument that was given or has a default.
    #[must_use]
    pub fn arg_float(&self, name: &str) -> Option<f64> {
        self.value(name).map(|v| v.float)
    }

    /// Returns a string argument that was given or has a default.
    #[must_use]
    pub fn arg_text(&self, name: &str) -> Option<String> {
        // SAFETY: the engine keeps the string until `create` returns.
        self.value(name).and_then(|v| unsafe { v.text.get() }.map(str::to_owned))
    }

    /// Returns a list of integers. It is empty if the argument was not given and has no default.
    #[must_use]
    pub fn arg_ints(&self, name: &str) -> Vec<i64> {
        let Some(v) = self.value(name).filter(|v| !v.ints.is_null()) else { return Vec::new() };
        // SAFETY: the engine keeps the list until `create` returns.
        unsafe { core::slice::from_raw_parts(v.ints, v.len) }.to_vec()
    }

    /// Returns a list of strings. It is empty if the argument was not given and has no default.
    #[must_use]
    pub fn arg_texts(&self, name: &str) -> Vec<String> {
        self.texts(name).iter().map(owned).collect()
    }

    /// Returns the string at index `at` (from zero) of a list, if the list is long enough.
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

    /// Creates a pin or parameter. The type of the handle gives its direction and type.
    ///
    /// # Errors
    /// The name is taken or too long, or the engine is out of memory.
    pub fn item<T: Value, D: Dir>(
        &mut self,
        name: &str,
        doc: &str,
        initial: T,
    ) -> Result<Item<T, D>, Error> {
        self.declare(Decl::new(name, doc), initial)
    }

    /// Creates a pin or parameter from a full declaration.
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
        // SAFETY: this is the engine's function; `spec` and `slot` live for the duration of the
        // call.
        check(unsafe { item(self.host.ctx, &raw const spec, &raw mut slot) })?;
        NonNull::new(slot.cast_mut()).map(Item::from_slot).ok_or(Error::engine(Status::EINVAL))
    }

    pub(crate) fn uses(&self, what: &impl Touch) -> Vec<abi::Use> {
        let mut uses = Uses(self.borrowed.clone());
        what.touch(&mut uses);
        uses.0
    }

    /// Exports a function. With an empty name, the function has the instance's own name.
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

    /// Exports a function that accesses pins of type float and may yet run in a thread that is not for
    /// floating-point numbers, as in LinuxCNC.
    ///
    /// # Errors
    /// The name is taken or too long.
    pub fn integer_function<F: Update>(
        &mut self,
        name: &str,
        doc: &str,
        f: F,
    ) -> Result<(), Error> {
        self.function_with(name, doc, funct_flags::NO_FP, f)
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
        // SAFETY: this is the engine's function; ownership of the state passes with the call.
        check(unsafe { funct(self.host.ctx, &raw const spec) })
    }

    /// Declares a background task, which runs every `period_ns` of machine time, never in a
    /// realtime thread.
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
        // SAFETY: this is the engine's function; ownership of the state passes with the call.
        check(unsafe { task(self.host.ctx, &raw const spec) })
    }

    /// Creates a thread.
    ///
    /// # Errors
    /// The name is taken, or the period is shorter than that of an existing thread.
    pub fn thread(&mut self, name: &str, period_ns: i64) -> Result<(), Error> {
        self.thread_with(name, period_ns, 0)
    }

    /// Creates a thread to which no function that computes with floating-point numbers can be added.
    ///
    /// # Errors
    /// As [`Self::thread`].
    pub fn integer_thread(&mut self, name: &str, period_ns: i64) -> Result<(), Error> {
        self.thread_with(name, period_ns, thread_flags::NO_FP)
    }

    fn thread_with(&mut self, name: &str, period_ns: i64, flags: u32) -> Result<(), Error> {
        let spec = ThreadSpec {
            size: abi::size::<ThreadSpec>(),
            flags,
            name: Str::borrow(name),
            period_ns,
        };
        let thread = self.host.thread.ok_or(Error::engine(Status::EINVAL))?;
        // SAFETY: this is the engine's function; `spec` lives for the duration of the call.
        check(unsafe { thread(self.host.ctx, &raw const spec) })
    }

    /// Declares a command for users, `NAME name=value …`. The name is absolute, such as
    /// `motion.jog`. The command runs on the control thread.
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
        // SAFETY: this is the engine's function; ownership of the state passes with the call.
        check(unsafe { command(self.host.ctx, &raw const spec) })
    }

    /// Declares the action that first accesses the outside world. It runs after everything has been
    /// created, and never in `check`. If it fails, the load fails.
    ///
    /// # Errors
    /// The reason why the engine refused the action.
    pub fn on_open<F>(&mut self, f: F) -> Result<(), Error>
    where
        F: FnMut(&Call<'_>) -> Result<(), Error> + Send + 'static,
    {
        self.action(self.host.open, f)
    }

    /// Declares the action that drives the outputs to their safe levels. It must be lock-free and
    /// idempotent, and it must make the driver write all outputs again after a restart.
    ///
    /// # Errors
    /// The reason why the engine refused the action.
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
        // SAFETY: this is the engine's function; ownership of the state passes with the call.
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

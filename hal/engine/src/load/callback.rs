//! The C functions that a component may call while it is created.

use crate::{Error, load::create::Creating, sync::Arc};
use core::ffi::c_void;
use hal_abi::{
    ABI_MINOR, ActionSpec, ArgValue, CommandSpec, FunctSpec, Host, ItemSpec, Record, ServiceRef,
    ServiceSpec, Slot, SnapshotRef, SnapshotSpec, Status, Str, StreamRef, StreamSpec, TaskSpec,
    ThreadSpec, WorkerSpec, host_flags,
};

impl Creating<'_> {
    /// Returns the record of functions for one instance.
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
        if self.engine.runtime.is_dry_run() || self.engine.model.staged().is_dry() {
            flags |= host_flags::TRIAL;
        }
        if self.engine.options.interlock {
            flags |= host_flags::INTERLOCK;
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
            bind: Some(bind),
            worker: Some(worker),
            snapshot: Some(snapshot),
            measured: Some(measured),
        }
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
declare!(worker, WorkerSpec, |c, s| c.worker(&s));
declare!(command, CommandSpec, |c, s| c.command(&s));
declare!(offer, ServiceSpec, |c, s| c.offer(&s));
declare!(open, ActionSpec, |c, s| {
    let code = c.action(&s);
    c.opens.extend(code);
    Ok(())
});
declare!(stop, ActionSpec, |c, s| {
    let code = c.action(&s);
    if let Some(component) = c.engine.model.component_mut(c.component) {
        component.stops.extend(code.map(Arc::new));
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
    // SAFETY: the place belongs to the component and is live.
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
        // SAFETY: the place belongs to the component and is live.
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
        // SAFETY: the place belongs to the component and is live.
        unsafe { out.write(made) };
    });
    c.answer(made)
}

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn snapshot(
    ctx: *mut c_void,
    spec: *const SnapshotSpec,
    out: *mut SnapshotRef,
) -> Status {
    let c = creating(ctx);
    // SAFETY: the component's record lives across its call.
    let Some(s) = (unsafe { SnapshotSpec::read(spec) }) else { return Status::EINVAL };
    let made = c.snapshot(&s).map(|made| {
        // SAFETY: the place belongs to the component and is live.
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
        // SAFETY: the place belongs to the component and is live.
        unsafe { out.write(table) };
    });
    c.answer(found)
}

/// # Safety
/// Called by a component during `create` with the context and slots of that call.
unsafe extern "C" fn measured(ctx: *mut c_void, pin: *const Slot, into: *const Slot) -> Status {
    let c = creating(ctx);
    let asked = c.measured(pin, into);
    c.answer(asked)
}

/// # Safety
/// Called by a component during `create` with the context and records of that call.
unsafe extern "C" fn bind(
    ctx: *mut c_void,
    name: Str,
    version: u32,
    out: *mut ServiceRef,
) -> Status {
    let c = creating(ctx);
    let bound = c.bind(name, version).map(|found| {
        // SAFETY: the place belongs to the component and is live.
        unsafe { out.write(found) };
    });
    c.answer(bound)
}

//! What the engine offers: to `create`, and to everything that runs later.

use crate::{
    ActionSpec, CommandSpec, FunctSpec, ItemSpec, Record, Ring, ServiceSpec, Slot, Status, Str,
    StreamSpec, TaskSpec, ThreadSpec, Ticket, Use,
};
use core::{ffi::c_void, mem::offset_of};

/// Bits of [`Host::flags`].
pub mod host_flags {
    /// Hardware is simulated: a driver works on a register file whose bits are pins.
    pub const SIMULATED: u32 = 1;
    /// The clock is virtual: machine time stands still within a function.
    pub const VIRTUAL: u32 = 2;
    /// The library was loaded from a file, so its language runtime is its own: it may change how
    /// a panic is reported.
    pub const PRIVATE: u32 = 4;
    /// The instance is on trial (`check`): nothing it makes will ever run.
    pub const TRIAL: u32 = 8;
    /// Since minor 4: the instance is a machine from an INI file, so motion needs the service
    /// `interlock`.
    pub const INTERLOCK: u32 = 16;
}

/// The value of an argument; which field counts follows from its type.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ArgValue {
    /// `size_of::<ArgValue>()` as compiled by the side that fills it.
    pub size: u32,
    /// Not zero: the user gave it, or it has a default.
    pub given: u32,
    /// The integer, or 0 and 1 for a truth value.
    pub int: i64,
    /// The floating-point number.
    pub float: f64,
    /// The string, valid for the call that asked.
    pub text: Str,
    /// The integers of a list, valid for the call that asked.
    pub ints: *const i64,
    /// The strings of a list, valid for the call that asked.
    pub texts: *const Str,
    /// How many items the list has.
    pub len: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ArgValue {
    const MIN: usize = size_of::<Self>();
}

impl ArgValue {
    /// Nothing given.
    pub const NONE: Self = Self {
        size: 0,
        given: 0,
        int: 0,
        float: 0.0,
        text: Str::NONE,
        ints: core::ptr::null(),
        texts: core::ptr::null(),
        len: 0,
    };
}

/// A ring that the host made.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct StreamRef {
    /// Its head, live until the component is unloaded.
    pub ring: *const Ring,
    /// Its depth.
    pub depth: u32,
    /// Its width.
    pub width: u32,
}

/// A service that was found.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ServiceRef {
    /// Its table, live until the component that found it is unloaded; null when it is not there.
    pub table: *const c_void,
    /// The pins, parameters and hidden state that its functions touch; valid until `create`
    /// returns.
    pub uses: *const Use,
    /// The number of uses.
    pub n_uses: usize,
}

/// What a component may call after `create`, from a function, a task, a command or an action.
///
/// The record handed to `create` lives until the component is unloaded; the one handed to a
/// command or an action lives for that call, and only there do `arg`, `reply` and `ticket` work.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallHost {
    /// `size_of::<CallHost>()` as the engine was compiled.
    pub size: u32,
    /// The bits of [`host_flags`].
    pub flags: u32,
    /// Passed back in every call.
    pub ctx: *const c_void,
    /// Realtime. Says `text` with numbers in the place of each `{}`; the text is static.
    pub message: Option<
        unsafe extern "C" fn(*const c_void, level: u8, text: Str, numbers: *const f64, n: usize),
    >,
    /// Realtime. Machine time in nanoseconds.
    pub now: Option<unsafe extern "C" fn(*const c_void) -> i64>,
    /// Why the call that now fails does so; copied.
    pub fail: Option<unsafe extern "C" fn(*const c_void, text: Str)>,
    /// The value of an argument of this call; lists and strings live until the call returns.
    pub arg: Option<unsafe extern "C" fn(*const c_void, name: Str, out: *mut ArgValue) -> Status>,
    /// Adds a line to the answer; copied.
    pub reply: Option<unsafe extern "C" fn(*const c_void, text: Str)>,
    /// A place to report the end of this command later.
    pub ticket: Option<unsafe extern "C" fn(*const c_void) -> *const Ticket>,
    /// Since minor 4: the caller waits for the ticket of this command, whether it asked to or not.
    pub awaited: Option<unsafe extern "C" fn(*const c_void)>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for CallHost {
    const MIN: usize = offset_of!(Self, awaited);
}
// SAFETY: the engine takes these calls from any thread; components never look behind `ctx`.
unsafe impl Sync for CallHost {}

/// What a component may call while it is created.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Host {
    /// `size_of::<Host>()` as the engine was compiled.
    pub size: u32,
    /// The engine's [`ABI_MINOR`](crate::ABI_MINOR).
    pub abi_minor: u32,
    /// Bits of [`host_flags`].
    pub flags: u32,
    /// The number of this instance, from zero.
    pub index: u32,
    /// The personality of this instance.
    pub personality: i64,
    /// The name of this instance, such as `and2.0`; for a type created once, its name.
    pub prefix: Str,
    /// Passed back in every call.
    pub ctx: *mut c_void,
    /// What it may call later.
    pub calls: *const CallHost,
    /// Why creation now fails, in the user's words; copied.
    pub fail: Option<unsafe extern "C" fn(*mut c_void, text: Str)>,
    /// The value of a `loadrt` argument; lists and strings live until `create` returns.
    pub arg: Option<unsafe extern "C" fn(*mut c_void, name: Str, out: *mut ArgValue) -> Status>,
    /// Creates a pin or parameter.
    pub item:
        Option<unsafe extern "C" fn(*mut c_void, *const ItemSpec, *mut *const Slot) -> Status>,
    /// Exports a function.
    pub funct: Option<unsafe extern "C" fn(*mut c_void, *const FunctSpec) -> Status>,
    /// Creates a thread.
    pub thread: Option<unsafe extern "C" fn(*mut c_void, *const ThreadSpec) -> Status>,
    /// Declares background work.
    pub task: Option<unsafe extern "C" fn(*mut c_void, *const TaskSpec) -> Status>,
    /// Declares a command.
    pub command: Option<unsafe extern "C" fn(*mut c_void, *const CommandSpec) -> Status>,
    /// Declares what touches the outside world first; run after all of the load was created,
    /// never by `check`.
    pub open: Option<unsafe extern "C" fn(*mut c_void, *const ActionSpec) -> Status>,
    /// Declares what drives the outputs to their safe levels; idempotent, takes no lock.
    pub stop: Option<unsafe extern "C" fn(*mut c_void, *const ActionSpec) -> Status>,
    /// Makes a ring.
    pub stream:
        Option<unsafe extern "C" fn(*mut c_void, *const StreamSpec, *mut StreamRef) -> Status>,
    /// Offers a service.
    pub offer: Option<unsafe extern "C" fn(*mut c_void, *const ServiceSpec) -> Status>,
    /// Finds a service and keeps its provider loaded. The caller's functions take over its uses.
    pub find: Option<
        unsafe extern "C" fn(*mut c_void, name: Str, version: u32, *mut *const c_void) -> Status,
    >,
    /// Since minor 4: finds a service as `find` does, with what its functions touch. A service
    /// that is not there is no error and has no table; one of another version is an error.
    pub bind: Option<
        unsafe extern "C" fn(*mut c_void, name: Str, version: u32, *mut ServiceRef) -> Status,
    >,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Host {
    const MIN: usize = offset_of!(Self, bind);
}

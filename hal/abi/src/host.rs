//! Functions that the engine offers to `create` and to code that runs later.

use crate::{
    ActionSpec, CommandSpec, FunctSpec, ItemSpec, Record, Ring, ServiceSpec, Slot, SnapshotRef,
    SnapshotSpec, Status, Str, StreamSpec, TaskSpec, ThreadSpec, Ticket, Use, WorkerSpec,
};
use core::{ffi::c_void, mem::offset_of};

/// Bits of [`Host::flags`].
pub mod host_flags {
    /// Hardware is simulated: a driver works on a register file whose bits are pins.
    pub const SIMULATED: u32 = 1;
    /// The clock is virtual: machine time stands still within a function.
    pub const VIRTUAL: u32 = 2;
    /// The library was loaded from a file and has its own language runtime, so it may replace the
    /// panic hook.
    pub const PRIVATE: u32 = 4;
    /// The instance is a dry run (`check`): nothing that it creates will ever run.
    pub const TRIAL: u32 = 8;
    /// Since minor 4: the instance is a machine from an INI file, so motion needs the service
    /// `interlock`.
    pub const INTERLOCK: u32 = 16;
}

/// Value of an argument. Its type determines which field is used.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ArgValue {
    /// `size_of::<ArgValue>()` of the side that fills it.
    pub size: u32,
    /// Not zero if the user passed the argument or it has a default.
    pub given: u32,
    /// Integer value; 0 or 1 for a boolean.
    pub int: i64,
    /// Floating-point value.
    pub float: f64,
    /// String value, valid for the duration of the call that requested it.
    pub text: Str,
    /// Integers of a list, valid for the duration of the call that requested them.
    pub ints: *const i64,
    /// Strings of a list, valid for the duration of the call that requested them.
    pub texts: *const Str,
    /// Number of items in the list.
    pub len: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ArgValue {
    const MIN: usize = size_of::<Self>();
}

impl ArgValue {
    /// The value of an argument that was not passed and has no default.
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

/// A ring that the host created.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct StreamRef {
    /// Header of the ring, live until the component is unloaded.
    pub ring: *const Ring,
    /// Number of slots.
    pub depth: u32,
    /// Number of values in a record.
    pub width: u32,
}

/// A service that was looked up.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ServiceRef {
    /// Function table of the service, live until the component that looked it up is unloaded. Null
    /// if the service does not exist.
    pub table: *const c_void,
    /// Pins, parameters and hidden state that the functions of the service access. Valid until
    /// `create` returns.
    pub uses: *const Use,
    /// Number of entries in `uses`.
    pub n_uses: usize,
}

/// Functions that a component may call after `create`: from a function, a task, a command or an
/// action.
///
/// The record passed to `create` lives until the component is unloaded. The record passed to a
/// command or action lives for that call, and `arg`, `reply` and `ticket` work only there.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CallHost {
    /// `size_of::<CallHost>()` of the engine.
    pub size: u32,
    /// Bits of [`host_flags`].
    pub flags: u32,
    /// Context that is passed to every call.
    pub ctx: *const c_void,
    /// Realtime. Logs `text`, with a number in the place of each `{}`. The text must be static.
    pub message: Option<
        unsafe extern "C" fn(*const c_void, level: u8, text: Str, numbers: *const f64, n: usize),
    >,
    /// Realtime. Returns machine time in nanoseconds.
    pub now: Option<unsafe extern "C" fn(*const c_void) -> i64>,
    /// Sets the reason why the current call fails. The text is copied.
    pub fail: Option<unsafe extern "C" fn(*const c_void, text: Str)>,
    /// Returns the value of an argument of this call. Lists and strings live until the call
    /// returns.
    pub arg: Option<unsafe extern "C" fn(*const c_void, name: Str, out: *mut ArgValue) -> Status>,
    /// Adds a line to the answer. The text is copied.
    pub reply: Option<unsafe extern "C" fn(*const c_void, text: Str)>,
    /// Returns a ticket through which a function later reports the end of this command.
    pub ticket: Option<unsafe extern "C" fn(*const c_void) -> *const Ticket>,
    /// Since minor 4: makes the caller wait for the ticket of this command, even if it did not ask
    /// to.
    pub awaited: Option<unsafe extern "C" fn(*const c_void)>,
    /// Since minor 9: asks for the value of a pin, parameter or signal, and returns the number of
    /// the question. For workers; the control side answers later.
    pub ask_value: Option<unsafe extern "C" fn(*const c_void, name: Str) -> u64>,
    /// Since minor 9: takes the answer to a question. `EAGAIN` while there is none, `ENOENT` if
    /// nothing has the name or nobody has asked.
    pub take_value: Option<unsafe extern "C" fn(*const c_void, question: u64, *mut f64) -> Status>,
    /// Since minor 11: realtime. Returns the number of gaps in time so far: times in which no thread ran although it was
    /// to, because the process or the computer stood still, or threads were stopped and started.
    pub gaps: Option<unsafe extern "C" fn(*const c_void) -> u32>,
    /// Since minor 12: realtime. Tells that a part of the component's hardware has failed (1) or works again (0). Each
    /// part that has failed is reported once, and once more when it works again.
    pub hardware: Option<unsafe extern "C" fn(*const c_void, failed: u32)>,
    /// Since minor 12: realtime. Returns the number of parts of hardware, of all components, that have failed now, in the low
    /// half, and the number of failures so far, which goes round, in the high half.
    pub failed_hardware: Option<unsafe extern "C" fn(*const c_void) -> u64>,
}
/// A failure in the number of failures so far, which is the high half of [`CallHost::failed_hardware`].
pub const HARDWARE_FAILURE: u64 = 1 << 32;

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for CallHost {
    const MIN: usize = offset_of!(Self, awaited);
}
// SAFETY: the engine accepts these calls from any thread; components never dereference `ctx`.
unsafe impl Sync for CallHost {}

/// Functions that a component may call while it is created.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Host {
    /// `size_of::<Host>()` of the engine.
    pub size: u32,
    /// [`ABI_MINOR`](crate::ABI_MINOR) of the engine.
    pub abi_minor: u32,
    /// Bits of [`host_flags`].
    pub flags: u32,
    /// Number of this instance, from zero.
    pub index: u32,
    /// Personality of this instance.
    pub personality: i64,
    /// Name of this instance, such as `and2.0`. For a type that is created once, the name of the
    /// type.
    pub prefix: Str,
    /// Context that is passed to every call.
    pub ctx: *mut c_void,
    /// Functions that the component may call later.
    pub calls: *const CallHost,
    /// Sets the reason why creation fails, in the user's words. The text is copied.
    pub fail: Option<unsafe extern "C" fn(*mut c_void, text: Str)>,
    /// Returns the value of a `loadrt` argument. Lists and strings live until `create` returns.
    pub arg: Option<unsafe extern "C" fn(*mut c_void, name: Str, out: *mut ArgValue) -> Status>,
    /// Creates a pin or parameter.
    pub item:
        Option<unsafe extern "C" fn(*mut c_void, *const ItemSpec, *mut *const Slot) -> Status>,
    /// Exports a function.
    pub funct: Option<unsafe extern "C" fn(*mut c_void, *const FunctSpec) -> Status>,
    /// Creates a thread.
    pub thread: Option<unsafe extern "C" fn(*mut c_void, *const ThreadSpec) -> Status>,
    /// Declares a background task.
    pub task: Option<unsafe extern "C" fn(*mut c_void, *const TaskSpec) -> Status>,
    /// Declares a command.
    pub command: Option<unsafe extern "C" fn(*mut c_void, *const CommandSpec) -> Status>,
    /// Declares the action that first accesses the outside world. It runs after everything in the
    /// load has been created, and never in `check`.
    pub open: Option<unsafe extern "C" fn(*mut c_void, *const ActionSpec) -> Status>,
    /// Declares the action that drives the outputs to their safe levels. It must be idempotent and
    /// take no lock.
    pub stop: Option<unsafe extern "C" fn(*mut c_void, *const ActionSpec) -> Status>,
    /// Creates a ring.
    pub stream:
        Option<unsafe extern "C" fn(*mut c_void, *const StreamSpec, *mut StreamRef) -> Status>,
    /// Offers a service.
    pub offer: Option<unsafe extern "C" fn(*mut c_void, *const ServiceSpec) -> Status>,
    /// Looks up a service and keeps its provider loaded. The functions of the caller inherit the
    /// service's uses.
    pub find: Option<
        unsafe extern "C" fn(*mut c_void, name: Str, version: u32, *mut *const c_void) -> Status,
    >,
    /// Since minor 4: looks up a service as `find` does, and returns what its functions access. A
    /// missing service is not an error; its table is null. A service of another version is an
    /// error.
    pub bind: Option<
        unsafe extern "C" fn(*mut c_void, name: Str, version: u32, *mut ServiceRef) -> Status,
    >,
    /// Since minor 5: declares a worker.
    pub worker: Option<unsafe extern "C" fn(*mut c_void, *const WorkerSpec) -> Status>,
    /// Since minor 5: creates the page of a snapshot.
    pub snapshot:
        Option<unsafe extern "C" fn(*mut c_void, *const SnapshotSpec, *mut SnapshotRef) -> Status>,
    /// Since minor 11: asks whether the value of a pin of this component is measured. The engine keeps the answer in
    /// `into`, a parameter of this component of type bit.
    pub measured:
        Option<unsafe extern "C" fn(*mut c_void, pin: *const Slot, into: *const Slot) -> Status>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Host {
    const MIN: usize = offset_of!(Self, bind);
}

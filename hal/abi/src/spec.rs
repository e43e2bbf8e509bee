//! Declarations of a library: its descriptor, and the records that `create` passes to the host.

use crate::{ArgSpec, ForeignLoader, Host, List, Record, Slot, Status, Str};
use core::ffi::c_void;

/// Panic strategy with which a library was built.
pub mod panic_strategy {
    /// Panics unwind and are caught at the ABI boundary.
    pub const UNWIND: u32 = 1;
    /// Panics abort the process. The engine refuses such a library.
    pub const ABORT: u32 = 2;
}

/// Descriptor that a plugin library exports as `hal_library_<file stem>`. The names in it are also
/// exported as [`names`](crate::names).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Library {
    /// `size_of::<Library>()` at compile time.
    pub size: u32,
    /// [`ABI_MAJOR`](crate::ABI_MAJOR) at compile time.
    pub abi_major: u32,
    /// [`ABI_MINOR`](crate::ABI_MINOR) at compile time.
    pub abi_minor: u32,
    /// Panic strategy, a constant in [`panic_strategy`].
    pub panic: u32,
    /// Component types in the library.
    pub components: List<ComponentType>,
    /// Loaders for files that are not plugins.
    pub loaders: List<ForeignLoader>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Library {
    const MIN: usize = core::mem::offset_of!(Self, loaders);
}

/// Bits of [`ComponentType::flags`].
pub mod component_flags {
    /// Created once per load, with absolute names. Without this flag, a type is created once per
    /// instance (`count=`, `names=`).
    pub const ONCE: u32 = 1;
    /// Takes `personality=`.
    pub const PERSONALITY: u32 = 2;
    /// Safe to use with its functions in threads on different processors.
    pub const PARALLEL: u32 = 4;
}

/// Creates one instance through the host. Must not unwind.
pub type Create = unsafe extern "C" fn(host: *const Host) -> Status;

/// A component type.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ComponentType {
    /// `size_of::<ComponentType>()` at compile time.
    pub size: u32,
    /// Bits of [`component_flags`].
    pub flags: u32,
    /// Type name, as in `loadrt NAME`.
    pub name: Str,
    /// Description in Markdown. The first line is a summary.
    pub doc: Str,
    /// Arguments of `loadrt` in addition to `count=`, `names=` and `personality=`.
    pub args: List<ArgSpec>,
    /// Pins and parameters of an instance, if they are fixed.
    pub items: List<ItemSpec>,
    /// Function that creates an instance.
    pub create: Option<Create>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ComponentType {
    const MIN: usize = size_of::<Self>();
}
// SAFETY: a descriptor is immutable static data.
unsafe impl Sync for ComponentType {}

/// Bits of [`ItemSpec::flags`].
pub mod item_flags {
    /// A bit of simulated hardware. `show` and `save` list it only if a pattern names it.
    pub const HIDDEN: u32 = 1;
    /// A limit switch or e-stop input. A machine that leaves it unlinked is not protected.
    pub const SAFETY: u32 = 2;
    /// Since minor 11: a value that a sensor measures, such as the position of an encoder.
    pub const MEASURED: u32 = 4;
}

/// A pin or parameter to create.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ItemSpec {
    /// `size_of::<ItemSpec>()` at compile time.
    pub size: u32,
    /// Bits of [`item_flags`].
    pub flags: u32,
    /// Name: absolute when passed to the host; in a descriptor, the part after the instance name.
    pub name: Str,
    /// Description in one line, with unit and range.
    pub doc: Str,
    /// Absolute name from before LinuxCNC distinguished joints and axes. Empty if there is none.
    pub old_name: Str,
    /// Initial value, as bits of a cell.
    pub initial: u64,
    /// External storage of a parameter, exactly as wide as its type. Null for a cell of the arena.
    pub storage: *mut c_void,
    /// Type code, a constant in [`ty`](crate::ty).
    pub ty: u8,
    /// Direction code, a constant in [`dir`](crate::dir).
    pub dir: u8,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ItemSpec {
    const MIN: usize = size_of::<Self>();
}
// SAFETY: an `ItemSpec` in a descriptor is immutable and has no storage.
unsafe impl Sync for ItemSpec {}

/// Bits of [`Use::access`].
pub mod access {
    /// The function reads the item.
    pub const READ: u32 = 1;
    /// The function writes the item.
    pub const WRITE: u32 = 2;
}

/// A pin, parameter or piece of hidden state that a function accesses. The layout of this record is
/// frozen.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// Slot of the item, or null for hidden state.
    pub slot: *const Slot,
    /// Identifier of the hidden state, unique within the component.
    pub token: u64,
    /// Bits of [`access`].
    pub access: u32,
}

/// Runs a function once. Must not unwind.
pub type Run = unsafe extern "C" fn(state: *mut c_void, period_ns: i64) -> Status;
/// Frees a state.
pub type Free = unsafe extern "C" fn(state: *mut c_void);

/// Bits of [`FunctSpec::flags`].
pub mod funct_flags {
    /// May be added to several threads, and several times to one thread.
    pub const REENTRANT: u32 = 1;
    /// The pins that the function reads and writes are unknown.
    pub const UNKNOWN: u32 = 2;
    /// The function belongs in a fast thread.
    pub const FAST: u32 = 4;
    /// The function computes with floating-point numbers. Without this bit and [`NO_FP`], it does so if
    /// it accesses a pin or parameter of type float.
    pub const FP: u32 = 8;
    /// The function may run in a thread that is not for floating-point numbers.
    pub const NO_FP: u32 = 16;
}

/// A function to export. The host owns the state from the call on, even if the call fails.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct FunctSpec {
    /// `size_of::<FunctSpec>()` at compile time.
    pub size: u32,
    /// Bits of [`funct_flags`].
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// Description in one line.
    pub doc: Str,
    /// Code of the function.
    pub run: Option<Run>,
    /// State of the function.
    pub state: *mut c_void,
    /// Function that frees the state.
    pub free: Option<Free>,
    /// Pins, parameters and hidden state that the function accesses.
    pub uses: *const Use,
    /// Number of entries in `uses`.
    pub n_uses: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for FunctSpec {
    const MIN: usize = size_of::<Self>();
}

/// Work that never runs in a realtime thread. The state is owned as in [`FunctSpec`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct TaskSpec {
    /// `size_of::<TaskSpec>()` at compile time.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// Description in one line.
    pub doc: Str,
    /// Period in nanoseconds of machine time.
    pub period_ns: i64,
    /// Code of the task. Its second argument is the period.
    pub run: Option<Run>,
    /// State of the task.
    pub state: *mut c_void,
    /// Function that frees the state.
    pub free: Option<Free>,
    /// Pins, parameters and hidden state that the task accesses.
    pub uses: *const Use,
    /// Number of entries in `uses`.
    pub n_uses: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for TaskSpec {
    const MIN: usize = size_of::<Self>();
}

/// Bits of [`ThreadSpec::flags`].
pub mod thread_flags {
    /// Functions that compute with floating-point numbers cannot be added.
    pub const NO_FP: u32 = 1;
}

/// A thread to create.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThreadSpec {
    /// `size_of::<ThreadSpec>()` at compile time.
    pub size: u32,
    /// Bits of [`thread_flags`].
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// Period in nanoseconds.
    pub period_ns: i64,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ThreadSpec {
    const MIN: usize = size_of::<Self>();
}

/// Directions of a [`StreamSpec`].
pub mod stream_direction {
    /// The component writes, a program reads (`sampler`).
    pub const OUT: u32 = 1;
    /// A program writes, the component reads (`streamer`).
    pub const IN: u32 = 2;
}

/// A ring that is shared with programs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct StreamSpec {
    /// `size_of::<StreamSpec>()` at compile time.
    pub size: u32,
    /// Direction, a constant in [`stream_direction`].
    pub direction: u32,
    /// Absolute name, such as `sampler.0`.
    pub name: Str,
    /// Number of slots, of which one always stays empty.
    pub depth: u32,
    /// Number of values in a record, at most [`MAX_WIDTH`](crate::MAX_WIDTH).
    pub width: u32,
    /// Type code of each value.
    pub types: [u8; 24],
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for StreamSpec {
    const MIN: usize = size_of::<Self>();
}

/// Code of a command or action. Runs on the control thread. Must not unwind.
pub type CommandRun =
    unsafe extern "C" fn(state: *mut c_void, call: *const crate::CallHost) -> Status;

/// A command for users, `COMPONENT.VERB name=value …`. The state is owned as in [`FunctSpec`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CommandSpec {
    /// `size_of::<CommandSpec>()` at compile time.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Absolute name, such as `motion.jog`.
    pub name: Str,
    /// Description. The first line is a summary.
    pub doc: Str,
    /// Arguments of the command.
    pub args: List<ArgSpec>,
    /// Code of the command.
    pub run: Option<CommandRun>,
    /// State of the command.
    pub state: *mut c_void,
    /// Function that frees the state.
    pub free: Option<Free>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for CommandSpec {
    const MIN: usize = size_of::<Self>();
}

/// Code that the engine runs when it opens or stops a component. The state is owned as in
/// [`FunctSpec`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ActionSpec {
    /// `size_of::<ActionSpec>()` at compile time.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Code of the action. Null if there is nothing to do.
    pub run: Option<CommandRun>,
    /// State of the action.
    pub state: *mut c_void,
    /// Function that frees the state.
    pub free: Option<Free>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ActionSpec {
    const MIN: usize = size_of::<Self>();
}

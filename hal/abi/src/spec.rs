//! What a library declares: its descriptor, and the records that `create` hands to the host.

use crate::{ForeignLoader, Host, List, Record, Slot, Status, Str};
use core::ffi::c_void;

/// How a library was built to panic.
pub mod panic_strategy {
    /// Panics unwind and are caught at the boundary.
    pub const UNWIND: u32 = 1;
    /// Panics end the process: such a library is refused.
    pub const ABORT: u32 = 2;
}

/// What a plugin library exports as `hal_library_<file stem>`; what it offers is also in its
/// [`names`](crate::names).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Library {
    /// `size_of::<Library>()` as compiled.
    pub size: u32,
    /// [`ABI_MAJOR`](crate::ABI_MAJOR) as compiled.
    pub abi_major: u32,
    /// [`ABI_MINOR`](crate::ABI_MINOR) as compiled.
    pub abi_minor: u32,
    /// One of [`panic_strategy`].
    pub panic: u32,
    /// The component types.
    pub components: List<ComponentType>,
    /// The kinds of other files that it loads.
    pub loaders: List<ForeignLoader>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Library {
    const MIN: usize = core::mem::offset_of!(Self, loaders);
}

/// Bits of [`ComponentType::flags`].
pub mod component_flags {
    /// Created once per load, with absolute names; otherwise once per instance
    /// (`count=`, `names=`).
    pub const ONCE: u32 = 1;
    /// Takes `personality=`.
    pub const PERSONALITY: u32 = 2;
    /// Safe with its functions in threads on different processors.
    pub const PARALLEL: u32 = 4;
}

/// Creates one instance through the host. Never unwinds.
pub type Create = unsafe extern "C" fn(host: *const Host) -> Status;

/// One component type.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ComponentType {
    /// `size_of::<ComponentType>()` as compiled.
    pub size: u32,
    /// Bits of [`component_flags`].
    pub flags: u32,
    /// Type name, as in `loadrt NAME`.
    pub name: Str,
    /// What it is, in Markdown; the first line is a summary.
    pub doc: Str,
    /// The `loadrt` arguments beside `count=`, `names=` and `personality=`.
    pub args: List<ArgSpec>,
    /// The pins and parameters of an instance, where they are fixed.
    pub items: List<ItemSpec>,
    /// Creates an instance.
    pub create: Option<Create>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ComponentType {
    const MIN: usize = size_of::<Self>();
}
// SAFETY: a descriptor is immutable static data.
unsafe impl Sync for ComponentType {}

/// Types of arguments of `loadrt` and of commands.
pub mod arg {
    /// One integer, in C's notation.
    pub const INT: u32 = 1;
    /// One floating-point number.
    pub const FLOAT: u32 = 2;
    /// One string.
    pub const TEXT: u32 = 3;
    /// Integers separated by commas.
    pub const INTS: u32 = 4;
    /// Strings separated by commas.
    pub const TEXTS: u32 = 5;
    /// A truth value.
    pub const BIT: u32 = 6;
}

/// An argument of `loadrt` or of a command.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ArgSpec {
    /// `size_of::<ArgSpec>()` as compiled.
    pub size: u32,
    /// One of [`arg`].
    pub kind: u32,
    /// The most items of a list; zero: no bound.
    pub most: u32,
    /// Not zero: it must be given.
    pub required: u32,
    /// As in `NAME=VALUE`.
    pub name: Str,
    /// What it means, with unit and range.
    pub doc: Str,
    /// The value when it is not given, as a user would write it; empty: nothing.
    pub default: Str,
}
// SAFETY: an `ArgSpec` is immutable static data.
unsafe impl Sync for ArgSpec {}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ArgSpec {
    const MIN: usize = size_of::<Self>();
}

impl ArgSpec {
    /// An argument of the given kind (one of [`arg`]).
    pub const fn new(kind: u32, name: &'static str, doc: &'static str) -> Self {
        Self {
            size: crate::size::<Self>(),
            kind,
            most: 0,
            required: 0,
            name: Str::new(name),
            doc: Str::new(doc),
            default: Str::NONE,
        }
    }

    /// The same, with a value for when it is not given, written as a user would.
    pub const fn or(mut self, default: &'static str) -> Self {
        self.default = Str::new(default);
        self
    }

    /// The same, but it must be given.
    pub const fn required(mut self) -> Self {
        self.required = 1;
        self
    }

    /// The same, with at most `n` items.
    pub const fn at_most(mut self, n: u32) -> Self {
        self.most = n;
        self
    }
}

/// Bits of [`ItemSpec::flags`].
pub mod item_flags {
    /// A bit of simulated hardware: `show` and `save` give it only when a pattern names it.
    pub const HIDDEN: u32 = 1;
    /// A limit switch or e-stop input: left unlinked, a machine is not protected.
    pub const SAFETY: u32 = 2;
}

/// One pin or parameter to create.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ItemSpec {
    /// `size_of::<ItemSpec>()` as compiled.
    pub size: u32,
    /// Bits of [`item_flags`].
    pub flags: u32,
    /// The name: absolute when passed to the host; in a descriptor, what follows the instance.
    pub name: Str,
    /// One line of documentation, with unit and range.
    pub doc: Str,
    /// The name before joints and axes were told apart, absolute; empty: none.
    pub old_name: Str,
    /// Initial value.
    pub initial: u64,
    /// A parameter's own storage, at exactly the width of its type; null: a cell of the arena.
    pub storage: *mut c_void,
    /// One of [`ty`](crate::ty).
    pub ty: u8,
    /// One of [`dir`](crate::dir).
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
    /// The function reads it.
    pub const READ: u32 = 1;
    /// The function writes it.
    pub const WRITE: u32 = 2;
}

/// A pin, parameter or piece of hidden state that a function touches. Its layout is frozen.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// The item, or null for hidden state.
    pub slot: *const Slot,
    /// Which hidden state, unique within the component.
    pub token: u64,
    /// Bits of [`access`].
    pub access: u32,
}

/// Runs a function once. Never unwinds.
pub type Run = unsafe extern "C" fn(state: *mut c_void, period_ns: i64) -> Status;
/// Frees a state.
pub type Free = unsafe extern "C" fn(state: *mut c_void);

/// Bits of [`FunctSpec::flags`].
pub mod funct_flags {
    /// May be in several threads, and several times in one.
    pub const REENTRANT: u32 = 1;
    /// What it reads and writes is not known.
    pub const UNKNOWN: u32 = 2;
    /// Belongs in a fast thread.
    pub const FAST: u32 = 4;
}

/// A function to export. The host owns the state from the call on, even when it fails.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct FunctSpec {
    /// `size_of::<FunctSpec>()` as compiled.
    pub size: u32,
    /// Bits of [`funct_flags`].
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// One line of documentation.
    pub doc: Str,
    /// The code.
    pub run: Option<Run>,
    /// Its state.
    pub state: *mut c_void,
    /// How to free the state.
    pub free: Option<Free>,
    /// What it touches.
    pub uses: *const Use,
    /// How many.
    pub n_uses: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for FunctSpec {
    const MIN: usize = size_of::<Self>();
}

/// Work that is never done in a realtime thread. Ownership of the state as in [`FunctSpec`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct TaskSpec {
    /// `size_of::<TaskSpec>()` as compiled.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// One line of documentation.
    pub doc: Str,
    /// How often, in nanoseconds of machine time.
    pub period_ns: i64,
    /// The code; its second argument is the period.
    pub run: Option<Run>,
    /// Its state.
    pub state: *mut c_void,
    /// How to free the state.
    pub free: Option<Free>,
    /// What it touches.
    pub uses: *const Use,
    /// How many.
    pub n_uses: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for TaskSpec {
    const MIN: usize = size_of::<Self>();
}

/// A thread to create.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThreadSpec {
    /// `size_of::<ThreadSpec>()` as compiled.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// Its period in nanoseconds.
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

/// A ring shared with programs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct StreamSpec {
    /// `size_of::<StreamSpec>()` as compiled.
    pub size: u32,
    /// One of [`stream_direction`].
    pub direction: u32,
    /// Absolute name, such as `sampler.0`.
    pub name: Str,
    /// How many slots; one less is usable.
    pub depth: u32,
    /// How many values a record has, at most [`MAX_WIDTH`](crate::MAX_WIDTH).
    pub width: u32,
    /// The type code of each value.
    pub types: [u8; 24],
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for StreamSpec {
    const MIN: usize = size_of::<Self>();
}

/// A command's or an action's code. Runs on the control side; never unwinds.
pub type CommandRun =
    unsafe extern "C" fn(state: *mut c_void, call: *const crate::CallHost) -> Status;

/// A command for users, `COMPONENT.VERB name=value …`. Ownership as in [`FunctSpec`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CommandSpec {
    /// `size_of::<CommandSpec>()` as compiled.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Absolute name, such as `motion.jog`.
    pub name: Str,
    /// What it does; the first line is a summary.
    pub doc: Str,
    /// Its arguments.
    pub args: List<ArgSpec>,
    /// The code.
    pub run: Option<CommandRun>,
    /// Its state.
    pub state: *mut c_void,
    /// How to free the state.
    pub free: Option<Free>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for CommandSpec {
    const MIN: usize = size_of::<Self>();
}

/// What the engine asks a component to do at a turn of its life. Ownership as in [`FunctSpec`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ActionSpec {
    /// `size_of::<ActionSpec>()` as compiled.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// The code; null: nothing to do.
    pub run: Option<CommandRun>,
    /// Its state.
    pub state: *mut c_void,
    /// How to free the state.
    pub free: Option<Free>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ActionSpec {
    const MIN: usize = size_of::<Self>();
}

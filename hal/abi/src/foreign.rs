//! Files that are not plugins: how a library registers as their loader, and the functions that it
//! may call.

use crate::{Host, ItemSpec, Record, Status, Str};
use core::ffi::c_void;

/// Loads one file. Everything that the file creates goes through the host. Must not unwind.
pub type Load = unsafe extern "C" fn(host: *const Host, file: *const ForeignFile) -> Status;

/// A loader of files that are not plugins.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ForeignLoader {
    /// `size_of::<ForeignLoader>()` at compile time.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Symbol that identifies the files of this loader: they export it.
    pub symbol: Str,
    /// Kind of the files, for messages, such as `component in C`.
    pub kind: Str,
    /// Function that loads a file.
    pub load: Option<Load>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ForeignLoader {
    const MIN: usize = size_of::<Self>();
}
// SAFETY: immutable static data.
unsafe impl Sync for ForeignLoader {}

/// Operations of [`ForeignFile::edit`], with the meaning of `a`, `b` and `number` for each.
pub mod edit {
    /// Creates signal `a` with type code `number`.
    pub const NEW_SIGNAL: u32 = 1;
    /// Deletes signal `a`.
    pub const DELETE_SIGNAL: u32 = 2;
    /// Links pin `a` to signal `b`.
    pub const LINK: u32 = 3;
    /// Unlinks pin `a`.
    pub const UNLINK: u32 = 4;
    /// Adds function `a` to thread `b` at position `number`.
    pub const ADD: u32 = 5;
    /// Adds function `a` to run once in the first cycle of thread `b`, at position `number`.
    pub const ADD_INIT: u32 = 6;
    /// Removes function `a` from thread `b`.
    pub const REMOVE: u32 = 7;
    /// Starts the threads.
    pub const START: u32 = 8;
    /// Stops the threads.
    pub const STOP: u32 = 9;
    /// Gives pin `a` the alias `b`. An empty `b` removes the alias.
    pub const ALIAS_PIN: u32 = 10;
    /// Gives parameter `a` the alias `b`. An empty `b` removes the alias.
    pub const ALIAS_PARAM: u32 = 11;
    /// Sets parameter `a` to the text `b`.
    pub const SET: u32 = 12;
    /// Sets the lock level to `number`.
    pub const LOCK: u32 = 13;
}

/// A file to load, and the functions that its loader may call in addition to those of [`Host`].
///
/// `item`, `rename`, `need`, `edit`, `join` and `describe` take [`Host::ctx`] and may be called while the file is
/// loaded. The other functions take the `ctx` of [`CallHost`](crate::CallHost) and may be called
/// until the component is unloaded.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ForeignFile {
    /// `size_of::<ForeignFile>()` of the engine.
    pub size: u32,
    /// Id of the component that is being created.
    pub component: u32,
    /// Instance of the engine: the same pointer for all of its files.
    pub instance: *const c_void,
    /// Path of the file.
    pub path: Str,
    /// Name of the file, as in `loadrt NAME`.
    pub name: Str,
    /// Prefix of every name that the file creates; usually empty.
    pub prefix: Str,
    /// Arguments after the name.
    pub words: *const Str,
    /// Number of arguments.
    pub n_words: usize,
    /// Creates a pin or parameter of component `owner`. For a pin, the engine stores the address of
    /// its cell at `place` and updates it with every link.
    pub item: Option<
        unsafe extern "C" fn(
            *mut c_void,
            *const ItemSpec,
            owner: u32,
            place: *mut *mut c_void,
        ) -> Status,
    >,
    /// Sets the name of the component.
    pub rename: Option<unsafe extern "C" fn(*mut c_void, name: Str) -> Status>,
    /// Declares that this component uses component `number`, which then cannot be unloaded first.
    pub need: Option<unsafe extern "C" fn(*mut c_void, number: u32) -> Status>,
    /// Changes the graph; see [`edit`].
    pub edit:
        Option<unsafe extern "C" fn(*mut c_void, what: u32, a: Str, b: Str, number: i64) -> Status>,
    /// Realtime. Logs `text`, which is copied. Level 0 is always shown.
    pub say: Option<unsafe extern "C" fn(*const c_void, level: u8, text: Str)>,
    /// Sets the highest message level that is shown, unless `level` is negative. Returns the
    /// previous one.
    pub level: Option<unsafe extern "C" fn(*const c_void, level: i32) -> i32>,
    /// Reports that the component allocated `bytes` more of its own memory, or freed it if
    /// negative.
    pub account: Option<unsafe extern "C" fn(*const c_void, bytes: i64)>,
    /// Creates a further component of the same file, which is removed with the first, and stores its
    /// id. May be called while the file is loaded.
    pub join: Option<unsafe extern "C" fn(*mut c_void, name: Str, id: *mut u32) -> Status>,
    /// Sets the description of the file. May be called while the file is loaded.
    pub describe: Option<unsafe extern "C" fn(*mut c_void, doc: Str) -> Status>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ForeignFile {
    const MIN: usize = size_of::<Self>();
}

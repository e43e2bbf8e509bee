//! Files of another kind: how a library registers as their loader, and what that may call.

use crate::{Host, ItemSpec, Record, Status, Str};
use core::ffi::c_void;

/// Loads one file. Everything it makes goes through the host; never unwinds.
pub type Load = unsafe extern "C" fn(host: *const Host, file: *const ForeignFile) -> Status;

/// A loader of files that are not plugins.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ForeignLoader {
    /// `size_of::<ForeignLoader>()` as compiled.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Files that export this symbol are of its kind.
    pub symbol: Str,
    /// What its files are, for messages, such as `component in C`.
    pub kind: Str,
    /// The code.
    pub load: Option<Load>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ForeignLoader {
    const MIN: usize = size_of::<Self>();
}
// SAFETY: immutable static data.
unsafe impl Sync for ForeignLoader {}

/// What [`ForeignFile::edit`] does; `a`, `b` and `number` are said beside each.
pub mod edit {
    /// Makes signal `a` of type code `number`.
    pub const NEW_SIGNAL: u32 = 1;
    /// Deletes signal `a`.
    pub const DELETE_SIGNAL: u32 = 2;
    /// Links pin `a` to signal `b`.
    pub const LINK: u32 = 3;
    /// Unlinks pin `a`.
    pub const UNLINK: u32 = 4;
    /// Adds function `a` to thread `b` at position `number`.
    pub const ADD: u32 = 5;
    /// As [`ADD`], for the thread's first cycle.
    pub const ADD_INIT: u32 = 6;
    /// Takes function `a` out of thread `b`.
    pub const REMOVE: u32 = 7;
    /// Starts the threads.
    pub const START: u32 = 8;
    /// Stops them.
    pub const STOP: u32 = 9;
    /// Gives pin `a` the alias `b`; empty: none.
    pub const ALIAS_PIN: u32 = 10;
    /// Gives parameter `a` the alias `b`; empty: none.
    pub const ALIAS_PARAM: u32 = 11;
    /// Sets parameter `a` to the text `b`.
    pub const SET: u32 = 12;
    /// Sets the lock level to `number`.
    pub const LOCK: u32 = 13;
}

/// A file to load, and what its loader may call beside [`Host`]'s functions.
///
/// `item`, `rename`, `need` and `edit` take [`Host::ctx`] and work while the file is loaded. The
/// others take the `ctx` of [`CallHost`](crate::CallHost) and work until the component is gone.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ForeignFile {
    /// `size_of::<ForeignFile>()` as the engine was compiled.
    pub size: u32,
    /// The number of the component that is being made.
    pub component: u32,
    /// Which instance it is: the same for all its files.
    pub instance: *const c_void,
    /// The file.
    pub path: Str,
    /// Its name, as in `loadrt NAME`.
    pub name: Str,
    /// What every name that the file makes begins with; usually empty.
    pub prefix: Str,
    /// The words after the name.
    pub words: *const Str,
    /// How many.
    pub n_words: usize,
    /// Creates a pin or parameter of component `owner`. For a pin, the address of its cell is
    /// kept at `place`, from now on and with every link.
    pub item: Option<
        unsafe extern "C" fn(
            *mut c_void,
            *const ItemSpec,
            owner: u32,
            place: *mut *mut c_void,
        ) -> Status,
    >,
    /// The component calls itself so.
    pub rename: Option<unsafe extern "C" fn(*mut c_void, name: Str) -> Status>,
    /// This component uses component `number`, which cannot be unloaded before it.
    pub need: Option<unsafe extern "C" fn(*mut c_void, number: u32) -> Status>,
    /// Changes the graph; see [`edit`].
    pub edit:
        Option<unsafe extern "C" fn(*mut c_void, what: u32, a: Str, b: Str, number: i64) -> Status>,
    /// Realtime. Says `text`, which is copied; level 0 is always shown.
    pub say: Option<unsafe extern "C" fn(*const c_void, level: u8, text: Str)>,
    /// Sets the level up to which messages are shown, unless negative; the one before comes back.
    pub level: Option<unsafe extern "C" fn(*const c_void, level: i32) -> i32>,
    /// The component takes so many bytes more of its own memory, or less.
    pub account: Option<unsafe extern "C" fn(*const c_void, bytes: i64)>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ForeignFile {
    const MIN: usize = size_of::<Self>();
}

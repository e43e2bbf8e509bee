//! Declaration of workers: work that may take long, and that never runs in a realtime thread.

use crate::{Free, Record, Status, Str, Use};
use core::ffi::c_void;

/// Code of one step of a worker. Does at most `items` items of work and returns how many it did, or
/// a negative errno if it failed. Must not unwind.
pub type Work = unsafe extern "C" fn(state: *mut c_void, items: u32) -> Status;

/// A worker. The state is owned as in [`FunctSpec`](crate::FunctSpec).
///
/// On the real clock each worker has an ordinary thread of its own, where it may wait for files. On
/// the virtual clock it makes one step at each multiple of its period.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct WorkerSpec {
    /// `size_of::<WorkerSpec>()` at compile time.
    pub size: u32,
    /// Must be zero.
    pub flags: u32,
    /// Absolute name.
    pub name: Str,
    /// Description in one line.
    pub doc: Str,
    /// Period in nanoseconds of machine time.
    pub period_ns: i64,
    /// Code of a step.
    pub run: Option<Work>,
    /// State of the worker.
    pub state: *mut c_void,
    /// Function that frees the state.
    pub free: Option<Free>,
    /// Pins, parameters and hidden state that the worker accesses.
    pub uses: *const Use,
    /// Number of entries in `uses`.
    pub n_uses: usize,
    /// Maximum number of items of a step, at least 1. On the real clock, the next step follows at
    /// once after a step that did this number, otherwise at the next multiple of the period.
    pub items: u32,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for WorkerSpec {
    const MIN: usize = size_of::<Self>();
}

//! Realtime. Which code of which component runs in this thread.

use crate::module::Module;
use core::ffi::{c_int, c_long, c_void};
use hal_component::abi::Status;
use std::sync::Arc;

/// A function of a component in C, as `shim.c` has it.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Running {
    pub(crate) code: extern "C" fn(*mut c_void, c_long),
    pub(crate) arg: *mut c_void,
    module: *const c_void,
}

/// The state of an exported function: first what `shim.c` reads.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) running: Running,
    /// Held so that the code and its memory live.
    module: Arc<Module>,
}

unsafe extern "C" {
    safe fn ferrule_current() -> *const Running;
    safe fn ferrule_swap(next: *const Running) -> *const Running;
    /// Runs a [`State`] once.
    pub(crate) fn ferrule_run(state: *mut c_void, period_ns: i64) -> Status;
}

impl State {
    pub(crate) fn new(
        code: extern "C" fn(*mut c_void, c_long),
        arg: *mut c_void,
        module: Arc<Module>,
    ) -> Self {
        let running = Running { code, arg, module: Arc::as_ptr(&module).cast() };
        Self { running, module }
    }
}

/// The module whose code runs in this thread.
pub(crate) fn module() -> Option<&'static Module> {
    // SAFETY: set for the time that the code runs, which its module outlives.
    let running = unsafe { ferrule_current().as_ref() }?;
    // SAFETY: as above.
    unsafe { running.module.cast::<Module>().as_ref() }
}

extern "C" fn nothing(_: *mut c_void, _: c_long) {}

/// Runs an entry point of a module.
pub(crate) fn within(module: *const Module, code: impl FnOnce() -> c_int) -> c_int {
    let me = Running { code: nothing, arg: core::ptr::null_mut(), module: module.cast() };
    let before = ferrule_swap(&raw const me);
    let result = code();
    ferrule_swap(before);
    result
}

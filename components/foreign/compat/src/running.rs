//! Realtime. Record of the component code that runs in this thread.

use crate::module::Module;
use core::ffi::{c_int, c_long, c_void};
use hal_component::abi::Status;
use std::sync::Arc;

/// Function of a component in C, with the layout of `shim.c`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Running {
    pub(crate) code: extern "C" fn(*mut c_void, c_long),
    pub(crate) arg: *mut c_void,
    module: *const c_void,
}

/// State of an exported funct; its first field is the record that `shim.c` reads.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) running: Running,
    /// Reference that keeps the code and its memory alive.
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

/// Returns the module whose code runs in this thread.
pub(crate) fn module() -> Option<&'static Module> {
    // SAFETY: set while the code runs, and its module outlives that time.
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

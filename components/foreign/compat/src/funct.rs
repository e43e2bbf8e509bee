//! Functions of the interface for components, functs, threads, signals and links.

use crate::{
    loading::{Loading, loading},
    module::Module,
    pin::{change, refuse, text},
    running::{self, State, ferrule_run},
    second_setup::no_component,
};
use core::ffi::{c_char, c_int, c_long, c_uchar, c_ulong, c_void};
use hal_component::abi::{
    FunctSpec, Status, Str, ThreadSpec, edit, funct_flags, size, thread_flags,
};
use std::{
    ffi::CString,
    sync::{Arc, PoisonError, atomic::Ordering::Relaxed},
};

#[unsafe(no_mangle)]
extern "C" fn hal_init(name: *const c_char) -> c_int {
    let Some(l) = loading() else {
        return refuse(None, Status::EINVAL.0, "hal_init belongs into rtapi_app_main");
    };
    let Some(name) = text(name) else {
        return refuse(Some(l), Status::EINVAL.0, "hal_init: no name");
    };
    let full = format!("{}{name}", l.module.prefix);
    if l.module.named.swap(true, Relaxed) {
        return join(l, &full);
    }
    // SAFETY: the engine's function; the text lives across the call.
    let named = l.file.rename.map(|f| unsafe { f(l.host.ctx, Str::borrow(&full)) });
    match named {
        Some(status) if !status.is_ok() => status.0,
        _ => l.module.id(),
    }
}

/// Makes a further component of the same module, and returns its number.
fn join(l: &Loading, name: &str) -> c_int {
    let mut number = 0;
    let Some(join) = l.file.join else { return Status::EINVAL.0 };
    // SAFETY: the engine's function; the text and the number live across the call.
    let status = unsafe { join(l.host.ctx, Str::borrow(name), &raw mut number) };
    if !status.is_ok() {
        l.refusals.borrow_mut().push(no_component(name));
        return status.0;
    }
    let number = c_int::try_from(number).unwrap_or(c_int::MAX);
    let name = CString::new(name).unwrap_or_default();
    l.module.further.lock().unwrap_or_else(PoisonError::into_inner).push((number, name));
    number
}

#[unsafe(no_mangle)]
extern "C" fn hal_exit(_component: c_int) -> c_int {
    // The engine removes the pins and functs together with the component.
    0
}

#[unsafe(no_mangle)]
extern "C" fn hal_ready(component: c_int) -> c_int {
    mark(component, true)
}

#[unsafe(no_mangle)]
extern "C" fn hal_unready(component: c_int) -> c_int {
    mark(component, false)
}

#[unsafe(no_mangle)]
extern "C" fn hal_set_unready(component: c_int) -> c_int {
    mark(component, false)
}

fn mark(component: c_int, ready: bool) -> c_int {
    let Some(l) = loading() else { return 0 };
    if l.module.id() == component {
        l.module.ready.store(ready, Relaxed);
    }
    0
}

#[unsafe(no_mangle)]
extern "C" fn hal_malloc(bytes: c_long) -> *mut c_void {
    let module = loading().map(|l| &*l.module).or_else(running::module);
    let taken = usize::try_from(bytes).ok().and_then(|bytes| module?.take(bytes));
    taken.map_or(core::ptr::null_mut(), <*mut u8>::cast)
}

#[unsafe(no_mangle)]
extern "C" fn hal_comp_name(component: c_int) -> *const c_char {
    let module = loading().map(|l| &*l.module).or_else(running::module);
    let Some(module) = module else { return core::ptr::null() };
    if module.id() == component {
        return module.name.as_ptr();
    }
    // A name in the list stays where it is until the module is unloaded.
    let further = module.further.lock().unwrap_or_else(PoisonError::into_inner);
    let found = further.iter().find(|(number, _)| *number == component);
    found.map_or(core::ptr::null(), |(_, name)| name.as_ptr())
}

#[unsafe(no_mangle)]
extern "C" fn hal_strerror(error: c_int) -> *const c_char {
    // SAFETY: a C string of the C library's.
    unsafe { libc::strerror(error.saturating_abs()) }
}

#[unsafe(no_mangle)]
extern "C" fn hal_set_constructor(_component: c_int, _make: *const c_void) -> c_int {
    // No command of this system would use it.
    0
}

/// Frees the state of a funct.
///
/// # Safety
/// The engine calls this once, with a state made by [`hal_export_funct`].
unsafe extern "C" fn free_state(state: *mut c_void) {
    // SAFETY: made by `Box::into_raw` as a `State`; freed once.
    drop(unsafe { Box::from_raw(state.cast::<State>()) });
}

/// Releases a reference to a module.
///
/// # Safety
/// The engine calls this once, with a pointer from `Arc::into_raw`.
pub(crate) unsafe extern "C" fn free_module(module: *mut c_void) {
    // SAFETY: guaranteed by the caller.
    drop(unsafe { Arc::from_raw(module.cast::<Module>().cast_const()) });
}

#[unsafe(no_mangle)]
extern "C" fn hal_export_funct(
    name: *const c_char,
    code: Option<extern "C" fn(*mut c_void, c_long)>,
    arg: *mut c_void,
    uses_fp: c_int,
    reentrant: c_int,
    component: c_int,
) -> c_int {
    let Some(l) = loading() else {
        return refuse(None, Status::EINVAL.0, "functions are exported by rtapi_app_main");
    };
    let (Some(name), Some(code)) = (text(name), code) else {
        return refuse(Some(l), Status::EINVAL.0, "a function has no name or no code");
    };
    if component == l.module.id() && l.module.ready.load(Relaxed) {
        let why = format!("'{name}': called after hal_ready");
        return refuse(Some(l), Status::EINVAL.0, &why);
    }
    let name = format!("{}{name}", l.module.prefix);
    let state = Box::new(State::new(code, arg, l.module.clone()));
    let flag = |is_set: c_int, flag: u32| if is_set != 0 { flag } else { 0 };
    let flags = flag(reentrant, funct_flags::REENTRANT) | flag(uses_fp, funct_flags::FP);
    let spec = FunctSpec {
        size: size::<FunctSpec>(),
        flags: funct_flags::UNKNOWN | flags,
        name: Str::borrow(&name),
        doc: Str::borrow(l.module.docs.funct(&name)),
        run: Some(ferrule_run),
        state: Box::into_raw(state).cast(),
        free: Some(free_state),
        uses: core::ptr::null(),
        n_uses: 0,
    };
    // SAFETY: the engine's function; ownership of the state passes with the call.
    l.host.funct.map_or(Status::EINVAL, |f| unsafe { f(l.host.ctx, &raw const spec) }).0
}

#[unsafe(no_mangle)]
extern "C" fn hal_create_thread(name: *const c_char, period: c_ulong, uses_fp: c_int) -> c_int {
    let Some(l) = loading() else {
        return refuse(None, Status::EINVAL.0, "threads are created by rtapi_app_main");
    };
    let Some(name) = text(name) else { return Status::EINVAL.0 };
    let name = format!("{}{name}", l.module.prefix);
    let spec = ThreadSpec {
        size: size::<ThreadSpec>(),
        flags: if uses_fp == 0 { thread_flags::NO_FP } else { 0 },
        name: Str::borrow(&name),
        period_ns: i64::try_from(period).unwrap_or(0),
    };
    // SAFETY: the engine's function; the record lives across the call.
    l.host.thread.map_or(Status::EINVAL, |f| unsafe { f(l.host.ctx, &raw const spec) }).0
}

#[unsafe(no_mangle)]
extern "C" fn hal_thread_delete(_name: *const c_char) -> c_int {
    // A thread is removed with the component that made it.
    0
}

#[unsafe(no_mangle)]
extern "C" fn hal_add_funct_to_thread(
    funct: *const c_char,
    thread: *const c_char,
    position: c_int,
) -> c_int {
    change(edit::ADD, funct, thread, i64::from(position))
}

#[unsafe(no_mangle)]
extern "C" fn hal_init_funct_to_thread(
    funct: *const c_char,
    thread: *const c_char,
    position: c_int,
) -> c_int {
    change(edit::ADD_INIT, funct, thread, i64::from(position))
}

#[unsafe(no_mangle)]
extern "C" fn hal_del_funct_from_thread(funct: *const c_char, thread: *const c_char) -> c_int {
    if loading().is_none() {
        // During unload: the engine itself removes functs from threads.
        return 0;
    }
    change(edit::REMOVE, funct, thread, 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_start_threads() -> c_int {
    change(edit::START, core::ptr::null(), core::ptr::null(), 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_stop_threads() -> c_int {
    if loading().is_none() {
        // During unload: the engine has already stopped the threads where needed.
        return 0;
    }
    change(edit::STOP, core::ptr::null(), core::ptr::null(), 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_signal_new(name: *const c_char, ty: c_int) -> c_int {
    change(edit::NEW_SIGNAL, name, core::ptr::null(), i64::from(ty))
}

#[unsafe(no_mangle)]
extern "C" fn hal_signal_delete(name: *const c_char) -> c_int {
    change(edit::DELETE_SIGNAL, name, core::ptr::null(), 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_link(pin: *const c_char, signal: *const c_char) -> c_int {
    change(edit::LINK, pin, signal, 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_unlink(pin: *const c_char) -> c_int {
    change(edit::UNLINK, pin, core::ptr::null(), 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_set_lock(level: c_uchar) -> c_int {
    change(edit::LOCK, core::ptr::null(), core::ptr::null(), i64::from(level))
}

#[unsafe(no_mangle)]
extern "C" fn hal_get_lock() -> c_uchar {
    // A load starts only while loading is not locked, and nothing else calls this.
    0
}

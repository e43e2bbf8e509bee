//! C side of functions, commands and `create`: the single place for panics and ownership.

use crate::{
    Builder, Call, Component, Error, Period, Update, Work,
    abi::{CallHost, Host, Status, Str, host_flags},
};
use core::ffi::c_void;
use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Mutex, Once, PoisonError},
    thread::ThreadId,
};

/// Text and location of the last panic of each thread, until it is taken. Two threads of a library
/// may panic at the same time.
static LAST: Mutex<Vec<(ThreadId, String)>> = Mutex::new(Vec::new());
static HOOK: Once = Once::new();

/// Runs component code. Returns the text if it panics.
pub(crate) fn guarded<R>(code: impl FnOnce() -> R) -> Result<R, String> {
    catch_unwind(AssertUnwindSafe(code)).map_err(|payload| {
        let said = swap_last(None);
        let text = payload
            .downcast_ref::<&str>()
            .map(|s| (*s).to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned());
        // The payload may panic itself when it is dropped. The payload of that second panic is
        // leaked.
        if let Err(again) = catch_unwind(AssertUnwindSafe(|| drop(payload))) {
            let _: &mut _ = Box::leak(again);
        }
        said.or(text).unwrap_or_else(|| "panicked".to_owned())
    })
}

/// Installs a panic hook that prints nothing, in a library with its own runtime. The engine reports
/// the panic.
fn quiet() {
    HOOK.call_once(|| {
        std::panic::set_hook(Box::new(|info| {
            let payload = info.payload();
            let text = payload
                .downcast_ref::<&str>()
                .copied()
                .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
                .unwrap_or("panicked");
            let place = info.location().map(|l| format!(" ({}:{})", l.file(), l.line()));
            let said = format!("{text}{}", place.unwrap_or_default());
            swap_last(Some(said));
        }));
    });
}

/// Returns the text of this thread's last panic and stores `said` in its place.
fn swap_last(said: Option<String>) -> Option<String> {
    let me = std::thread::current().id();
    let mut all = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let mine = all.iter().position(|(thread, _)| *thread == me);
    let last = mine.map(|at| all.swap_remove(at).1);
    all.extend(said.map(|said| (me, said)));
    last
}

fn say(calls: &CallHost, text: &str) {
    if let Some(fail) = calls.fail {
        // SAFETY: this is the engine's function; `text` lives for the duration of the call.
        unsafe { fail(calls.ctx, Str::borrow(text)) };
    }
}

/// State of a function, and the engine's record for reporting a panic.
pub(crate) struct Running<F> {
    f: F,
    calls: &'static CallHost,
}

impl<F> Running<F> {
    pub(crate) const fn new(f: F, calls: &'static CallHost) -> Self {
        Self { f, calls }
    }
}

/// Moves a state to the heap and passes its ownership to the engine.
pub(crate) fn give<S>(state: S) -> *mut c_void {
    Box::into_raw(Box::new(state)).cast()
}

/// # Safety
/// `state` must have come from [`give`] as an `S` and must not be used again.
pub(crate) unsafe extern "C" fn free<S>(state: *mut c_void) {
    // SAFETY: the state came from `give`, and the engine frees it once.
    let state = unsafe { Box::from_raw(state.cast::<S>()) };
    drop(guarded(|| drop(state)));
}

/// Realtime.
///
/// # Safety
/// `state` must be a live `Running<F>` that nothing else accesses during the call.
pub(crate) unsafe extern "C" fn run<F: Update>(state: *mut c_void, period_ns: i64) -> Status {
    // SAFETY: the engine runs a function in one thread at a time and only before `free`.
    let running = unsafe { &mut *state.cast::<Running<F>>() };
    match guarded(|| running.f.update(Period::from_ns(period_ns))) {
        Ok(()) => Status::OK,
        Err(text) => {
            say(running.calls, &text);
            Status::EFAULT
        }
    }
}

/// # Safety
/// `state` must be a live `Running<F>` that nothing else accesses during the call.
pub(crate) unsafe extern "C" fn work<F: Work>(state: *mut c_void, items: u32) -> Status {
    // SAFETY: the engine runs a worker in one thread at a time and only before `free`.
    let running = unsafe { &mut *state.cast::<Running<F>>() };
    match guarded(|| running.f.work(items)) {
        Ok(done) => Status(i32::try_from(done).unwrap_or(i32::MAX)),
        Err(text) => {
            say(running.calls, &text);
            Status::EFAULT
        }
    }
}

/// # Safety
/// `state` must be a live `F` that nothing else accesses during the call. `call` must be the
/// engine's record.
pub(crate) unsafe extern "C" fn call<F>(state: *mut c_void, call: *const CallHost) -> Status
where
    F: FnMut(&Call<'_>) -> Result<(), Error>,
{
    // SAFETY: the engine runs commands one at a time and only before `free`.
    let f = unsafe { &mut *state.cast::<F>() };
    // SAFETY: the engine's record lives for the duration of the call.
    let calls = unsafe { &*call };
    match guarded(|| f(&Call(calls))) {
        Ok(Ok(())) => Status::OK,
        Ok(Err(e)) => {
            if let Some(text) = &e.text {
                say(calls, text);
            }
            e.status
        }
        Err(text) => {
            say(calls, &format!("panicked: {text}"));
            Status::EFAULT
        }
    }
}

/// # Safety
/// `host` must be the engine's record and live for the duration of the call.
#[doc(hidden)]
pub unsafe extern "C" fn create<C: Component>(host: *const Host) -> Status {
    // SAFETY: guaranteed by the caller.
    let host = unsafe { &*host };
    if host.flags & host_flags::PRIVATE != 0 {
        quiet();
    }
    let (status, text) = match guarded(|| C::create(&mut Builder::new(host, C::FLAGS))) {
        Ok(Ok(())) => return Status::OK,
        Ok(Err(e)) => (e.status, e.text.map(std::borrow::Cow::into_owned)),
        Err(text) => (Status::EFAULT, Some(format!("panicked: {text}"))),
    };
    if let (Some(text), Some(fail)) = (text, host.fail) {
        // SAFETY: this is the engine's function; `text` lives for the duration of the call.
        unsafe { fail(host.ctx, Str::borrow(&text)) };
    }
    status
}

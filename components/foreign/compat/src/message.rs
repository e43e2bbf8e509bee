//! Realtime. Messages of components, and the clock that they read.

use crate::{running, system};
use core::ffi::{CStr, c_char, c_int, c_long, c_longlong, c_void};
use hal_component::abi::level;

/// Level of a message that is always shown.
const ALL: c_int = 5;

/// Logs a message; `shim.c` calls this with the formatted text.
#[unsafe(no_mangle)]
extern "C" fn ferrule_say(level: c_int, text: *const c_char) {
    // SAFETY: a C string of the shim's.
    let text = unsafe { CStr::from_ptr(text) }.to_str().unwrap_or("?");
    let level =
        if level >= ALL { level::NOTICE } else { u8::try_from(level).unwrap_or(level::ERR) };
    let Some(module) = running::module() else {
        write_error(&[text]);
        return;
    };
    for line in text.lines().filter(|l| !l.is_empty()) {
        module.say(level, line);
    }
}

/// Writes to standard error, for code that runs outside an instance.
pub(crate) fn write_error(parts: &[&str]) {
    for part in parts {
        // SAFETY: a live text.
        unsafe { libc::write(2, part.as_ptr().cast(), part.len()) };
    }
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_set_msg_level(level: c_int) -> c_int {
    if let (0..=ALL, Some(module)) = (level, running::module()) {
        module.level(level);
        return 0;
    }
    -libc::EINVAL
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_get_msg_level() -> c_int {
    running::module().map_or(c_int::from(level::ERR), |m| m.level(-1))
}

unsafe extern "C" {
    safe fn ferrule_handler() -> *const c_void;
    safe fn ferrule_default_handler();
}

/// Restores the default message handler before the file that holds the present one is closed.
pub(crate) fn forget_handler(handle: *mut c_void) {
    if system::belongs(handle, ferrule_handler()) {
        ferrule_default_handler();
    }
}

/// Realtime. Returns machine time in nanoseconds; in threads that a component made itself, the system's monotonic time.
fn now() -> i64 {
    running::module().map_or_else(monotonic, crate::module::Module::now)
}

fn monotonic() -> i64 {
    let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: memory for the result.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut t) };
    t.tv_sec.saturating_mul(1_000_000_000).saturating_add(t.tv_nsec)
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_get_time() -> c_longlong {
    now()
}

/// Number of clocks in a millisecond, for drivers that were written for the kernel. They declare it as an `int` or as a
/// `long`.
#[unsafe(export_name = "cpu_khz")]
static CPU_KHZ: u64 = 1_000_000;

#[unsafe(no_mangle)]
extern "C" fn rtapi_get_clocks() -> c_longlong {
    now()
}

/// Longest busy wait, in nanoseconds.
const MAX_DELAY_NS: c_long = 10_000;

#[unsafe(no_mangle)]
extern "C" fn rtapi_delay(ns: c_long) {
    if running::module().is_some_and(crate::module::Module::is_virtual) {
        return;
    }
    let end = monotonic() + if ns < MAX_DELAY_NS { ns } else { MAX_DELAY_NS };
    while monotonic() < end {
        core::hint::spin_loop();
    }
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_delay_max() -> c_long {
    MAX_DELAY_NS
}

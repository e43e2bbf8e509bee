//! Other functions of the interface: tasks, which the engine provides; and files and devices, which simulated
//! hardware does not have.

use crate::{access::hardware, outside, running};
use core::ffi::{CStr, c_char, c_int, c_long, c_longlong, c_uint, c_ulong, c_void};

fn simulated() -> bool {
    running::module().is_some_and(crate::module::Module::is_simulated)
}

fn not_here(what: &str) -> c_int {
    if let Some(m) = running::module() {
        m.say(hal_component::abi::level::ERR, what);
    }
    -libc::ENOSYS
}

fn no_pci() -> c_int {
    if simulated() {
        outside::note("rtapi_pci_register_driver", "");
    } else {
        not_here("no PCI devices are offered to components in C");
    }
    -libc::ENODEV
}

macro_rules! answers {
    ($($name:ident($($arg:ident: $ty:ty),*) -> $result:ty = $value:expr;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($($arg: $ty),*) -> $result {
            $value
        }
    )*};
}

answers! {
    rtapi_init(_name: *const c_char) -> c_int = running::module().map_or(1, crate::module::Module::id);
    rtapi_exit(_module: c_int) -> c_int = 0;
    rtapi_is_kernelspace() -> c_int = 0;
    rtapi_is_realtime() -> c_int = c_int::from(!simulated());
    rtapi_get_realtime_type() -> c_int = REALTIME_UNKNOWN;
    hal_get_realtime_type() -> c_int = REALTIME_UNKNOWN;
    rtapi_clock_set_period(_ns: c_long) -> c_long = 0;
    rtapi_prio_highest() -> c_int = 98;
    rtapi_prio_lowest() -> c_int = 1;
    rtapi_prio_next_higher(priority: c_int) -> c_int = (priority + 1).min(98);
    rtapi_prio_next_lower(priority: c_int) -> c_int = (priority - 1).max(1);
    rtapi_task_new(_code: *const c_void, _arg: *mut c_void, _priority: c_int, _owner: c_int,
        _stack: c_ulong, _uses_fp: c_int) -> c_int
        = not_here("a component has no tasks of its own here: export a function");
    rtapi_task_delete(_task: c_int) -> c_int = -libc::EINVAL;
    rtapi_task_start(_task: c_int, _period_ns: c_ulong) -> c_int = -libc::EINVAL;
    rtapi_task_pause(_task: c_int) -> c_int = -libc::EINVAL;
    rtapi_task_resume(_task: c_int) -> c_int = -libc::EINVAL;
    rtapi_task_self() -> c_int = -libc::EINVAL;
    rtapi_task_self_resync() -> c_int = 0;
    rtapi_wait() -> () = ();
    rtapi_task_pll_get_reference() -> c_longlong = 0;
    rtapi_task_pll_set_correction(_ns: c_long) -> c_int = 0;
    rtapi_pci_register_driver(_driver: *mut c_void) -> c_int = no_pci();
    rtapi_pci_unregister_driver(_driver: *mut c_void) -> () = ();
    rtapi_pci_enable_device(_device: *mut c_void) -> c_int = -libc::ENODEV;
    rtapi_pci_disable_device(_device: *mut c_void) -> c_int = -libc::ENODEV;
    rtapi_pci_ioremap_bar(_device: *mut c_void, _bar: c_int) -> *mut c_void
        = core::ptr::null_mut();
    rtapi_iounmap(_address: *mut c_void) -> () = ();
}

/// Value for an unknown kind of realtime system.
const REALTIME_UNKNOWN: c_int = 1;

#[unsafe(no_mangle)]
extern "C" fn rtapi_open_as_root(path: *const c_char, mode: c_int) -> c_int {
    if simulated() {
        outside::note("rtapi_open_as_root", crate::pin::text(path).unwrap_or_default());
        return hardware::refused(libc::EPERM);
    }
    // SAFETY: the component passes a C string.
    unsafe { libc::open(path, mode) }
}

#[unsafe(no_mangle)]
extern "C" fn simple_strtol(text: *const c_char, end: *mut *mut c_char, base: c_int) -> c_long {
    // SAFETY: the component passes a C string and memory for a pointer.
    unsafe { libc::strtol(text, end, base) }
}

/// Splits a text at blanks into a null-terminated list; a single block of memory holds list and words.
#[unsafe(no_mangle)]
extern "C" fn rtapi_argv_split(
    _flags: c_uint,
    text: *const c_char,
    count: *mut c_int,
) -> *mut *mut c_char {
    if text.is_null() {
        return core::ptr::null_mut();
    }
    // SAFETY: the component passes a C string.
    let text = unsafe { CStr::from_ptr(text) }.to_bytes();
    let words: Vec<&[u8]> = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
    let head = (words.len() + 1) * size_of::<*mut c_char>();
    // SAFETY: plain memory, zeroed; each word is at most as long as its part of the text.
    let list =
        unsafe { libc::calloc(1, head + text.len() + words.len() + 1) }.cast::<*mut c_char>();
    if list.is_null() {
        return list;
    }
    let mut at = list.wrapping_byte_add(head).cast::<u8>();
    for (i, word) in words.iter().enumerate() {
        // SAFETY: within the memory just allocated.
        unsafe { at.copy_from_nonoverlapping(word.as_ptr(), word.len()) };
        // SAFETY: as above.
        unsafe { list.wrapping_add(i).write(at.cast()) };
        at = at.wrapping_add(word.len() + 1);
    }
    if !count.is_null() {
        // SAFETY: the component's memory.
        unsafe { count.write(c_int::try_from(words.len()).unwrap_or(c_int::MAX)) };
    }
    list
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_argv_free(list: *mut *mut c_char) {
    // SAFETY: made by `rtapi_argv_split`, or null.
    unsafe { libc::free(list.cast()) };
}

/// Record with the layout that C components use.
#[repr(C)]
#[derive(Debug)]
struct Firmware {
    size: usize,
    bytes: *const u8,
    private: *mut c_void,
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_request_firmware(
    place: *mut *const Firmware,
    name: *const c_char,
    _device: *mut c_void,
) -> c_int {
    let Some(name) = crate::pin::text(name).filter(|n| !n.contains("..") && !place.is_null())
    else {
        return -libc::EINVAL;
    };
    let Ok(bytes) = std::fs::read(std::path::Path::new("/lib/firmware").join(name)) else {
        return -libc::ENOENT;
    };
    let bytes: &'static mut [u8] = Box::leak(bytes.into_boxed_slice());
    let firmware =
        Firmware { size: bytes.len(), bytes: bytes.as_ptr(), private: core::ptr::null_mut() };
    // SAFETY: the component's memory.
    unsafe { place.write(Box::into_raw(Box::new(firmware))) };
    0
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_release_firmware(firmware: *mut Firmware) {
    if firmware.is_null() {
        return;
    }
    // SAFETY: made by `rtapi_request_firmware`, released once.
    let firmware = unsafe { Box::from_raw(firmware) };
    let bytes = core::ptr::slice_from_raw_parts_mut(firmware.bytes.cast_mut(), firmware.size);
    // SAFETY: leaked there.
    drop(unsafe { Box::from_raw(bytes) });
}

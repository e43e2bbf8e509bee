//! Calls of the system's dynamic linker.

use core::ffi::{CStr, c_int, c_void};
use std::{
    ffi::CString,
    fs::File,
    io::Write,
    os::fd::{AsRawFd, FromRawFd, OwnedFd},
    path::Path,
};

fn said() -> String {
    // SAFETY: valid until the next call on this thread.
    let text = unsafe { libc::dlerror() };
    if text.is_null() {
        return "no reason given".to_owned();
    }
    // SAFETY: a C string of the linker's, copied at once.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

/// Opens a file with global symbols and immediate binding.
///
/// # Errors
/// The linker's message, which names a missing symbol.
pub(crate) fn open(path: &Path) -> Result<*mut c_void, String> {
    let path = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|e| e.to_string())?;
    // SAFETY: a module's initialisers are ordinary C.
    let handle = unsafe { libc::dlopen(path.as_ptr(), libc::RTLD_NOW | libc::RTLD_GLOBAL) };
    if handle.is_null() { Err(said()) } else { Ok(handle) }
}

/// Opens a copy of a file, with variables of its own. Its symbols serve the copy alone, which prefers them to those of
/// the original. The descriptor must stay open as long as the copy: the linker knows the copy by its number.
///
/// # Errors
/// The file cannot be read or copied, or the linker's message.
pub(crate) fn open_copy(path: &Path) -> Result<(*mut c_void, OwnedFd), String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let name = CString::new(path.file_name().unwrap_or_default().as_encoded_bytes());
    let name = name.map_err(|e| e.to_string())?;
    let create = |flags| {
        // SAFETY: a C string.
        unsafe { libc::memfd_create(name.as_ptr(), libc::MFD_CLOEXEC | flags) }
    };
    let mut fd = create(libc::MFD_EXEC);
    if fd < 0 {
        // Systems before Linux 6.3 do not know that flag, and need none.
        fd = create(0);
    }
    if fd < 0 {
        return Err(std::io::Error::last_os_error().to_string());
    }
    // SAFETY: opened just now, owned from here on.
    let mut file = unsafe { File::from_raw_fd(fd) };
    file.write_all(&bytes).map_err(|e| e.to_string())?;
    let shown = CString::new(format!("/proc/self/fd/{}", file.as_raw_fd()));
    let shown = shown.map_err(|e| e.to_string())?;
    let flags = libc::RTLD_NOW | libc::RTLD_LOCAL | libc::RTLD_DEEPBIND;
    // SAFETY: a module's initialisers are ordinary C.
    let handle = unsafe { libc::dlopen(shown.as_ptr(), flags) };
    if handle.is_null() { Err(said()) } else { Ok((handle, file.into())) }
}

/// Closes a file. Returns whether it is unmapped.
pub(crate) fn close(handle: *mut c_void) -> bool {
    let name = name_of(handle);
    // SAFETY: opened by `open`, closed once.
    unsafe { libc::dlclose(handle) };
    let Some(name) = name else { return true };
    // SAFETY: only queries whether the file is loaded.
    let still = unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_NOW | libc::RTLD_NOLOAD) };
    if still.is_null() {
        return true;
    }
    // SAFETY: releases the reference of that query.
    unsafe { libc::dlclose(still) };
    false
}

/// First fields of the linker's record of a file.
#[repr(C)]
struct LinkMap {
    base: u64,
    name: *const core::ffi::c_char,
}

fn map_of(handle: *mut c_void) -> Option<&'static LinkMap> {
    let mut map: *const LinkMap = core::ptr::null();
    let place: *mut *const LinkMap = &raw mut map;
    // SAFETY: an open handle, and memory for an address.
    let code = unsafe { libc::dlinfo(handle, libc::RTLD_DI_LINKMAP, place.cast()) };
    if code != 0 {
        return None;
    }
    // SAFETY: the linker's record, alive while the file is open.
    unsafe { map.as_ref() }
}

fn name_of(handle: *mut c_void) -> Option<CString> {
    let map = map_of(handle)?;
    // SAFETY: a C string of the linker's, copied at once.
    Some(unsafe { CStr::from_ptr(map.name) }.to_owned())
}

/// Returns the base address of a file in memory.
pub(crate) fn base(handle: *mut c_void) -> u64 {
    map_of(handle).map_or(0, |m| m.base)
}

/// Returns the address of a symbol of a file, or null.
pub(crate) fn symbol(handle: *mut c_void, name: &CStr) -> *mut c_void {
    // SAFETY: an open handle and a C string.
    unsafe { libc::dlsym(handle, name.as_ptr()) }
}

/// Returns whether a file itself defines a symbol.
pub(crate) fn defines(handle: *mut c_void, name: &CStr) -> bool {
    let address = symbol(handle, name);
    if address.is_null() {
        return false;
    }
    belongs(handle, address)
}

/// Returns whether an address lies in a file.
pub(crate) fn belongs(handle: *mut c_void, address: *const c_void) -> bool {
    let mut found = core::mem::MaybeUninit::<libc::Dl_info>::zeroed();
    // SAFETY: memory for the result.
    let known: c_int = unsafe { libc::dladdr(address, found.as_mut_ptr()) };
    // SAFETY: zeroed is valid; filled if known.
    let found = unsafe { found.assume_init() };
    known != 0 && found.dli_fbase.addr() as u64 == base(handle) && base(handle) != 0
}

/// Makes the symbols of this library global, so that modules find them.
pub(crate) fn offer_symbols() -> Result<(), String> {
    let mut found = core::mem::MaybeUninit::<libc::Dl_info>::zeroed();
    /// An object of this library.
    static HERE: u8 = 0;
    let here = (&raw const HERE).cast();
    // SAFETY: an address of this library, and memory for the result.
    if unsafe { libc::dladdr(here, found.as_mut_ptr()) } == 0 {
        return Err(said());
    }
    // SAFETY: filled by the loader.
    let found = unsafe { found.assume_init() };
    let flags = libc::RTLD_NOW | libc::RTLD_GLOBAL | libc::RTLD_NOLOAD;
    // SAFETY: the linker's C string for this file.
    let again = unsafe { libc::dlopen(found.dli_fname, flags) };
    if again.is_null() { Err(said()) } else { Ok(()) }
}

/// Returns whether a library of this name or path is open.
pub(crate) fn is_open(name: &[u8]) -> bool {
    let Ok(name) = CString::new(name) else { return false };
    // SAFETY: only queries whether the library is loaded.
    let open = unsafe { libc::dlopen(name.as_ptr(), libc::RTLD_LAZY | libc::RTLD_NOLOAD) };
    if open.is_null() {
        return false;
    }
    // SAFETY: releases the reference of that query.
    unsafe { libc::dlclose(open) };
    true
}

/// Returns the system's text for an error number.
pub(crate) fn explained(code: c_int) -> String {
    // SAFETY: a C string of the C library's, copied at once on the only thread that loads.
    let text = unsafe { libc::strerror(code.saturating_neg()) };
    // SAFETY: as above.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
}

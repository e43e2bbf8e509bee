//! Requests of C programs: `ferrule.h`.

use crate::{EINVAL, text};
use hal_protocol::{Client, Code, Failure, Link, Place, Reply, Request, Value, WireReply};
use std::{
    ffi::{CString, c_char, c_double, c_int},
    ptr,
};

/// A connection of a C program.
pub(crate) struct Handle {
    client: Client,
    /// Reason why the last call failed.
    why: CString,
}

/// Returns a text for C; a zero byte ends it.
fn c_text(text: &str) -> CString {
    let until = text.split('\0').next().unwrap_or_default();
    CString::new(until).unwrap_or_default()
}

fn ask(client: &mut Client, request: Request) -> WireReply {
    client.call(request).map_or_else(WireReply::Error, WireReply::Ok)
}

impl Handle {
    /// Keeps the reason of a failure and returns its number.
    fn failed(&mut self, failure: &Failure) -> c_int {
        self.why = c_text(&failure.to_string());
        if failure.code < 0 { failure.code } else { EINVAL }
    }

    fn value(&mut self, name: &str) -> Result<Value, Failure> {
        let mut reply = self.client.call(Request::Get { name: name.to_owned() });
        if reply.is_err()
            && let Ok(signal) = self.client.call(Request::GetSignal { name: name.to_owned() })
        {
            reply = Ok(signal);
        }
        match reply? {
            Reply::Value(value) => Ok(value),
            _ => Err(Failure::new(EINVAL, "the engine's answer does not match the request")),
        }
    }

    /// Sets what `value` reads: a pin or parameter, or the signal of this name where there is none.
    fn set(&mut self, name: &str, value: &str) -> Result<(), Failure> {
        let (name, value) = (name.to_owned(), value.to_owned());
        let set = Request::Set { name: name.clone(), value: value.clone() };
        let Err(why) = self.client.call(set) else { return Ok(()) };
        let is_unknown = |why: &Failure| why.finding == Some(Code::NoSuchName);
        if !is_unknown(&why) {
            return Err(why);
        }
        let set = self.client.call(Request::SetSignal { name, value });
        set.map(drop).map_err(|other| if is_unknown(&other) { why } else { other })
    }

    /// Keeps the reason of a text that is null or not UTF-8, and returns its number.
    fn no_text(&mut self) -> c_int {
        self.why = c_text("the name or the value is not a text in UTF-8");
        EINVAL
    }
}

/// Connects to an instance.
///
/// # Safety
/// `instance` is null or a C string; `why` is null or valid for a write.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_connect(
    instance: *const c_char,
    why: *mut *mut c_char,
) -> *mut Handle {
    // SAFETY: guaranteed by the caller.
    let name = unsafe { text(instance) };
    let client = match name {
        None if !instance.is_null() => Err(Failure::new(EINVAL, "the name is not UTF-8")),
        name => Place::find(name)
            .map_err(|why| Failure::new(EINVAL, why))
            .and_then(|place| Client::connect(&place, "")),
    };
    match client {
        Ok(client) => Box::into_raw(Box::new(Handle { client, why: CString::default() })),
        Err(failure) => {
            if !why.is_null() {
                let text = c_text(&failure.to_string()).into_raw();
                // SAFETY: guaranteed by the caller.
                unsafe { why.write(text) };
            }
            ptr::null_mut()
        }
    }
}

/// Ends a connection.
///
/// # Safety
/// The handle is null, or of `ferrule_connect` and not closed.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_close(handle: *mut Handle) {
    if !handle.is_null() {
        // SAFETY: guaranteed by the caller.
        drop(unsafe { Box::from_raw(handle) });
    }
}

/// Sends a request in JSON and returns the answer in JSON.
///
/// # Safety
/// The handle is null or of `ferrule_connect`; the request is a C string.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_request(
    handle: *mut Handle,
    request: *const c_char,
) -> *mut c_char {
    // SAFETY: guaranteed by the caller.
    let Some(handle) = (unsafe { handle.as_mut() }) else { return ptr::null_mut() };
    // SAFETY: guaranteed by the caller.
    let request = unsafe { text(request) };
    let request = request.ok_or_else(|| "the request is not UTF-8".to_owned());
    let parsed = request.and_then(|text| {
        serde_json::from_str::<Request>(text).map_err(|e| format!("not a request: {e}"))
    });
    let request = match parsed {
        Ok(request) => request,
        Err(why) => {
            handle.failed(&Failure::new(EINVAL, why));
            return ptr::null_mut();
        }
    };
    let reply = ask(&mut handle.client, request);
    if let WireReply::Error(failure) = &reply {
        handle.failed(failure);
        if handle.client.is_gone() {
            return ptr::null_mut();
        }
    }
    serde_json::to_string(&reply).map_or(ptr::null_mut(), |text| c_text(&text).into_raw())
}

/// Reads a value.
///
/// # Safety
/// The handle is null or of `ferrule_connect`; the name is a C string; `value` is null or valid for a write.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_get(
    handle: *mut Handle,
    name: *const c_char,
    value: *mut c_double,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    let handle = unsafe { handle.as_mut() };
    // SAFETY: guaranteed by the caller.
    let name = unsafe { text(name) };
    let Some(handle) = handle else { return EINVAL };
    let Some(name) = name else { return handle.no_text() };
    match handle.value(name) {
        Ok(found) if !value.is_null() => {
            // SAFETY: guaranteed by the caller.
            unsafe { value.write(found.number()) };
            0
        }
        Ok(_) => 0,
        Err(failure) => handle.failed(&failure),
    }
}

/// Sets a value.
///
/// # Safety
/// The handle is null or of `ferrule_connect`; name and value are C strings.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_set(
    handle: *mut Handle,
    name: *const c_char,
    value: *const c_char,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    let handle = unsafe { handle.as_mut() };
    // SAFETY: guaranteed by the caller.
    let name = unsafe { text(name) };
    // SAFETY: guaranteed by the caller.
    let value = unsafe { text(value) };
    let Some(handle) = handle else { return EINVAL };
    let (Some(name), Some(value)) = (name, value) else { return handle.no_text() };
    handle.set(name, value).map_or_else(|failure| handle.failed(&failure), |()| 0)
}

/// Returns the reason of the last failure.
///
/// # Safety
/// The handle is null or of `ferrule_connect`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_error(handle: *const Handle) -> *const c_char {
    // SAFETY: guaranteed by the caller.
    unsafe { handle.as_ref() }.map_or(c"no connection".as_ptr(), |handle| handle.why.as_ptr())
}

/// Frees a text of this library.
///
/// # Safety
/// The text is null, or of this library and not freed.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn ferrule_free(text: *mut c_char) {
    if !text.is_null() {
        // SAFETY: guaranteed by the caller.
        drop(unsafe { CString::from_raw(text) });
    }
}

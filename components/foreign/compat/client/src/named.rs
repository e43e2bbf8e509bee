//! Values of other components by name: `hal_get_pin_value_by_name` and its sisters.
//!
//! In LinuxCNC these functions return an address in the machine's memory. Here, each call asks the instance, and
//! returns the address of a copy that is as old as the call. The address of a name stays the same.

use crate::{EINVAL, item::Cell, text};
use hal_protocol::{Client, Direction, Failure, Kind, Link, Place, Reply, Request, Value};
use std::{
    collections::BTreeMap,
    ffi::{c_char, c_int, c_void},
    sync::{Mutex, PoisonError},
};

/// Connection for these requests, and the copies.
#[derive(Debug)]
struct ByName {
    client: Option<Client>,
    copies: BTreeMap<(bool, String), Cell>,
}

static BY_NAME: Mutex<ByName> = Mutex::new(ByName { client: None, copies: BTreeMap::new() });

/// Value of an item, and whether a pin is linked, or a signal written.
struct NamedValue {
    value: Value,
    flag: bool,
}

impl ByName {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        let client = match self.client.take() {
            Some(client) => client,
            None => {
                let place = Place::find(None).map_err(|why| Failure::new(EINVAL, why))?;
                Client::connect(&place, "")?
            }
        };
        self.client.insert(client).call(request)
    }

    fn find(&mut self, kind: Kind, name: &str) -> Option<NamedValue> {
        let patterns = vec![name.to_owned()];
        let Ok(reply) = self.call(Request::List { kind, patterns, ty: None }) else {
            // The next call connects again.
            self.client = None;
            return None;
        };
        match reply {
            Reply::Items(items) => {
                let is_it = |i: &hal_protocol::ItemInfo| {
                    i.name == name || i.original.as_deref() == Some(name)
                };
                let item = items.into_iter().find(is_it)?;
                Some(NamedValue { value: item.value, flag: item.signal.is_some() })
            }
            Reply::Signals(signals) => {
                let signal = signals.into_iter().find(|s| s.name == name)?;
                let flag = signal.pins.iter().any(|(d, _)| *d == Direction::Out);
                Some(NamedValue { value: signal.value, flag })
            }
            _ => None,
        }
    }

    /// Returns the copy of a value. Signals have names of their own.
    fn copy(&mut self, kind: Kind, name: &str, value: &Value) -> *mut c_void {
        let key = (kind == Kind::Signals, name.to_owned());
        let cell = self.copies.entry(key).or_insert_with(|| Cell::new(0));
        cell.store(value.bits());
        cell.address()
    }
}

/// Writes what C asks for: each address may be null. Returns 0, or -1 if no item has this name.
///
/// # Safety
/// The name is a C string; each other pointer is null or valid for a write.
unsafe fn get(
    kind: Kind,
    name: *const c_char,
    ty: *mut c_int,
    data: *mut *mut c_void,
    flag: *mut bool,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    let Some(name) = (unsafe { text(name) }) else { return -1 };
    let mut values = BY_NAME.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(found) = values.find(kind, name) else { return -1 };
    let at = values.copy(kind, name, &found.value);
    if !ty.is_null() {
        // SAFETY: guaranteed by the caller.
        unsafe { ty.write(c_int::from(found.value.ty().code())) };
    }
    if !data.is_null() {
        // SAFETY: guaranteed by the caller.
        unsafe { data.write(at) };
    }
    if !flag.is_null() {
        // SAFETY: guaranteed by the caller.
        unsafe { flag.write(found.flag) };
    }
    0
}

/// Returns the value of a pin, and whether it is linked.
///
/// # Safety
/// As for `get`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn hal_get_pin_value_by_name(
    name: *const c_char,
    ty: *mut c_int,
    data: *mut *mut c_void,
    connected: *mut bool,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { get(Kind::Pins, name, ty, data, connected) }
}

/// Returns the value of a signal, and whether an output is linked to it.
///
/// # Safety
/// As for `get`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn hal_get_signal_value_by_name(
    name: *const c_char,
    ty: *mut c_int,
    data: *mut *mut c_void,
    has_writers: *mut bool,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { get(Kind::Signals, name, ty, data, has_writers) }
}

/// Returns the value of a parameter.
///
/// # Safety
/// As for `get`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn hal_get_param_value_by_name(
    name: *const c_char,
    ty: *mut c_int,
    data: *mut *mut c_void,
) -> c_int {
    // SAFETY: guaranteed by the caller.
    unsafe { get(Kind::Params, name, ty, data, core::ptr::null_mut()) }
}

//! Library that `halcompile` links with C programs that have pins.
//!
//! In LinuxCNC, a program and the machine share memory. Here, the program's values lie in its own memory, and a thread
//! of this library exchanges them with the instance at an interval of machine time: 10 ms, or the value of
//! `HAL_POLL_MS`. At each exchange, values written by the program are sent, and values written by the machine are
//! received; a value that changes and changes back between two exchanges is not noticed. Parameters are pins with the
//! corresponding direction. Streams and ports are not offered.
//!
//! `request.rs` is the client of `ferrule.h`: requests and values by name, without a component.
//!
//! Functions with variable argument lists are in `client.c`, which is compiled with each program.
#![expect(unsafe_code, reason = "the interface is C's")]

mod exchange;
mod item;
mod named;
mod request;

use exchange::Component;
use item::{Cell, Item};
use std::{
    ffi::{CStr, c_char, c_int, c_long, c_void},
    sync::{Mutex, MutexGuard, PoisonError},
};

const EINVAL: c_int = -22;

/// Components of this process; the number of a component is its index plus 1.
static COMPONENTS: Mutex<Vec<Component>> = Mutex::new(Vec::new());

fn components() -> MutexGuard<'static, Vec<Component>> {
    COMPONENTS.lock().unwrap_or_else(PoisonError::into_inner)
}

fn of(list: &mut [Component], id: c_int) -> Option<&mut Component> {
    list.get_mut(usize::try_from(id).ok()?.checked_sub(1)?)
}

/// Reads a C string. Returns `None` for a null pointer or text that is not UTF-8.
///
/// # Safety
/// The string is terminated, and outlives the use of the result.
unsafe fn text<'a>(at: *const c_char) -> Option<&'a str> {
    if at.is_null() {
        return None;
    }
    // SAFETY: guaranteed by the caller.
    unsafe { CStr::from_ptr(at) }.to_str().ok()
}

/// Joins the instance as a component. Returns its number, or a negative error number.
///
/// # Safety
/// The name is a C string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hal_init(name: *const c_char) -> c_int {
    // SAFETY: guaranteed by the caller.
    let Some(name) = (unsafe { text(name) }) else { return EINVAL };
    match Component::join(name) {
        Ok(component) => {
            let mut list = components();
            list.push(component);
            c_int::try_from(list.len()).unwrap_or(EINVAL)
        }
        Err(failure) => exchange::report(name, &failure),
    }
}

/// Marks the component as complete: from now on, values are exchanged.
#[unsafe(no_mangle)]
pub extern "C" fn hal_ready(id: c_int) -> c_int {
    of(&mut components(), id).map_or(EINVAL, Component::ready)
}

/// Leaves the instance.
#[unsafe(no_mangle)]
pub extern "C" fn hal_exit(id: c_int) -> c_int {
    of(&mut components(), id).map_or(EINVAL, Component::leave)
}

/// Allocates zeroed memory that is never freed.
#[unsafe(no_mangle)]
pub extern "C" fn hal_malloc(size: c_long) -> *mut c_void {
    let words = usize::try_from(size).unwrap_or(0).div_ceil(16);
    let room: Vec<u128> = vec![0; words.max(1)];
    room.leak().as_mut_ptr().cast()
}

/// Makes a pin or parameter. Memory for a pin's value is allocated here, and `*place` set to its address; a parameter's
/// value is at `at`. `initial` is the initial value, for interfaces that pass one.
///
/// # Safety
/// The name is a C string; `place` and `at` are null, or memory of the program that is never freed, `at` as wide as its
/// type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ferrule_client_item(
    id: c_int,
    ty: c_int,
    dir: c_int,
    place: *mut *mut c_void,
    at: *mut c_void,
    initial: u64,
    name: *const c_char,
) -> c_int {
    let mut list = components();
    // SAFETY: guaranteed by the caller.
    let name = unsafe { text(name) };
    let (Some(component), Some(name)) = (of(&mut list, id), name) else { return EINVAL };
    let Some(mut item) = Item::new(ty, dir) else { return EINVAL };
    if at.is_null() {
        item.cell = Cell::new(initial);
    } else {
        // SAFETY: guaranteed by the caller.
        item.cell = unsafe { Cell::at(at, item.ty) };
    }
    if let Err(failure) = component.add(name, &item) {
        return exchange::report(name, &failure);
    }
    if !place.is_null() {
        // SAFETY: guaranteed by the caller.
        unsafe { place.write(item.cell.address()) };
    }
    component.items.push(item);
    0
}

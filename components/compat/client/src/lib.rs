//! Programs in C with pins: the library that `halcompile` links them with.
//!
//! In LinuxCNC a program and the machine share memory. Here the program's values lie in its own
//! memory, and a thread of this library exchanges them with the instance at an interval of machine
//! time: 10 ms, or what `HAL_POLL_MS` says. What the program writes goes out at the next exchange,
//! what the machine writes comes in then; a value that changes to and fro in between is not seen.
//! Parameters are pins of the direction that fits. Streams and ports are not offered.
//!
//! What has a variable number of arguments in C is in `client.c`, compiled with each program.
#![expect(unsafe_code, reason = "the interface is C's")]

mod exchange;
mod item;

use exchange::Component;
use item::{Cell, Item};
use std::{
    ffi::{CStr, c_char, c_int, c_long, c_void},
    sync::{Mutex, MutexGuard, PoisonError},
};

const EINVAL: c_int = -22;

/// The components of this process; their numbers are their places, from 1.
static COMPONENTS: Mutex<Vec<Component>> = Mutex::new(Vec::new());

fn components() -> MutexGuard<'static, Vec<Component>> {
    COMPONENTS.lock().unwrap_or_else(PoisonError::into_inner)
}

fn of(list: &mut [Component], id: c_int) -> Option<&mut Component> {
    list.get_mut(usize::try_from(id).ok()?.checked_sub(1)?)
}

/// A text of C; none for no address, or what is no text.
///
/// # Safety
/// It ends, and lives as long as the answer is used.
unsafe fn text<'a>(at: *const c_char) -> Option<&'a str> {
    if at.is_null() {
        return None;
    }
    // SAFETY: the caller's.
    unsafe { CStr::from_ptr(at) }.to_str().ok()
}

/// Joins the instance as a component: its number, or a negative error number.
///
/// # Safety
/// The name is a text of C.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hal_init(name: *const c_char) -> c_int {
    // SAFETY: the caller's.
    let Some(name) = (unsafe { text(name) }) else { return EINVAL };
    match Component::join(name) {
        Ok(component) => {
            let mut list = components();
            list.push(component);
            c_int::try_from(list.len()).unwrap_or(EINVAL)
        }
        Err(failure) => exchange::complain(name, &failure),
    }
}

/// The component is whole: values are exchanged from now on.
#[unsafe(no_mangle)]
pub extern "C" fn hal_ready(id: c_int) -> c_int {
    of(&mut components(), id).map_or(EINVAL, Component::ready)
}

/// Leaves the instance.
#[unsafe(no_mangle)]
pub extern "C" fn hal_exit(id: c_int) -> c_int {
    of(&mut components(), id).map_or(EINVAL, Component::leave)
}

/// Zeroed memory that is never given back.
#[unsafe(no_mangle)]
pub extern "C" fn hal_malloc(size: c_long) -> *mut c_void {
    let words = usize::try_from(size).unwrap_or(0).div_ceil(16);
    let room: Vec<u128> = vec![0; words.max(1)];
    room.leak().as_mut_ptr().cast()
}

/// Makes a pin or parameter. A pin's value is made here, and `*place` set to it; a parameter's is at
/// `at`. `initial` is where the value begins, for those whose interface says so.
///
/// # Safety
/// The name is a text of C; `place` and `at` are none, or memory of the program that is never given
/// back, `at` as wide as its type.
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
    // SAFETY: the caller's.
    let name = unsafe { text(name) };
    let (Some(component), Some(name)) = (of(&mut list, id), name) else { return EINVAL };
    let Some(mut item) = Item::new(ty, dir) else { return EINVAL };
    if at.is_null() {
        item.cell = Cell::new(initial);
    } else {
        // SAFETY: the caller's.
        item.cell = unsafe { Cell::at(at, item.ty) };
    }
    if let Err(failure) = component.add(name, &item) {
        return exchange::complain(name, &failure);
    }
    if !place.is_null() {
        // SAFETY: the caller's.
        unsafe { place.write(item.cell.address()) };
    }
    component.items.push(item);
    0
}

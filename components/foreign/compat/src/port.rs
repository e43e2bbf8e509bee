//! Realtime. Functions `hal_port_…`: byte queues behind pins of type port.
//!
//! A port pin holds the address of its queue, and a component reads an `int` there: the lower half. The queue is the one
//! whose address ends so, among the port pins of the module that runs.

use crate::running;
use core::{
    ffi::{c_char, c_int, c_uint},
    sync::atomic::{AtomicPtr, AtomicU64, Ordering},
};
use hal_component::abi::PortQueue;
use std::sync::OnceLock;

/// Addresses of the pointers to the port pins of one module, once its load is complete.
#[derive(Debug, Default)]
pub(crate) struct Ports(OnceLock<Box<[usize]>>);

impl Ports {
    /// Ends the load: from now on functions find the queues.
    pub(crate) fn complete(&self, places: Box<[usize]>) {
        drop(self.0.set(places));
    }

    /// Realtime. Returns the address of the queue whose lower half is `port`, or zero.
    fn find(&self, port: c_int) -> u64 {
        let places = self.0.get().map_or(&[][..], |p| p);
        let addresses = places.iter().map(|place| {
            let place = core::ptr::with_exposed_provenance_mut::<*mut AtomicU64>(*place);
            // SAFETY: the pointer is in the module's memory, aligned, and lives while its code runs.
            let pointer = unsafe { AtomicPtr::from_ptr(place) };
            // SAFETY: the engine sets it to a cell that lives as long as the pin.
            let cell = unsafe { pointer.load(Ordering::Relaxed).as_ref() };
            // Pairs with the store of whatever links the pin.
            cell.map_or(0, |c| c.load(Ordering::Acquire))
        });
        let mut known = addresses.filter(|a| *a != 0);
        known.find(|a| lower_half(*a) == port).unwrap_or(0)
    }
}

/// Returns the number that a component in C reads in a port pin.
#[expect(clippy::cast_possible_truncation, reason = "the lower half is meant")]
const fn lower_half(address: u64) -> c_int {
    address as c_int
}

/// Returns the queue of a port, if it has one.
fn queue<'q>(port: c_int) -> Option<&'q PortQueue> {
    let at = usize::try_from(running::module()?.ports.find(port)).unwrap_or(0);
    let at = core::ptr::with_exposed_provenance::<PortQueue>(at);
    // SAFETY: the value of a port pin: null, or the address of a queue that its signal owns.
    unsafe { at.as_ref() }
}

fn bytes<'b>(at: *mut c_char, count: c_uint) -> &'b mut [u8] {
    if at.is_null() || count == 0 {
        return &mut [];
    }
    // SAFETY: the component passes this number of its own bytes.
    unsafe { core::slice::from_raw_parts_mut(at.cast(), count as usize) }
}

fn number(n: u64) -> c_uint {
    c_uint::try_from(n).unwrap_or(c_uint::MAX)
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_read(port: c_int, to: *mut c_char, count: c_uint) -> bool {
    queue(port).is_some_and(|q| q.read(bytes(to, count)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_peek(port: c_int, to: *mut c_char, count: c_uint) -> bool {
    queue(port).is_some_and(|q| q.peek(bytes(to, count)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_peek_commit(port: c_int, count: c_uint) -> bool {
    let Some(q) = queue(port).filter(|q| u64::from(count) <= q.readable()) else { return false };
    let (mut left, mut gone) = (count as usize, [0; 64]);
    while left > 0 {
        let part = left.min(gone.len());
        if !q.read(gone.get_mut(..part).unwrap_or_default()) {
            return false;
        }
        left -= part;
    }
    true
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_write(port: c_int, from: *mut c_char, count: c_uint) -> bool {
    queue(port).is_some_and(|q| q.write(bytes(from, count)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_readable(port: c_int) -> c_uint {
    queue(port).map_or(0, |q| number(q.readable()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_writable(port: c_int) -> c_uint {
    queue(port).map_or(0, |q| number(q.writable()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_buffer_size(port: c_int) -> c_uint {
    queue(port).map_or(0, |q| number(q.size()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_clear(port: c_int) {
    if let Some(q) = queue(port) {
        q.clear();
    }
}

//! Realtime. Functions `hal_port_…`: byte queues behind pins of type port.

use core::ffi::{c_char, c_uint};
use hal_component::abi::PortQueue;

/// Returns the queue of a port, if it has one.
fn queue<'q>(port: i64) -> Option<&'q PortQueue> {
    let at = usize::try_from(port.cast_unsigned()).unwrap_or(0);
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
extern "C" fn hal_port_read(port: i64, to: *mut c_char, count: c_uint) -> bool {
    queue(port).is_some_and(|q| q.read(bytes(to, count)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_peek(port: i64, to: *mut c_char, count: c_uint) -> bool {
    queue(port).is_some_and(|q| q.peek(bytes(to, count)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_peek_commit(port: i64, count: c_uint) -> bool {
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
extern "C" fn hal_port_write(port: i64, from: *mut c_char, count: c_uint) -> bool {
    queue(port).is_some_and(|q| q.write(bytes(from, count)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_readable(port: i64) -> c_uint {
    queue(port).map_or(0, |q| number(q.readable()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_writable(port: i64) -> c_uint {
    queue(port).map_or(0, |q| number(q.writable()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_buffer_size(port: i64) -> c_uint {
    queue(port).map_or(0, |q| number(q.size()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_port_clear(port: i64) {
    if let Some(q) = queue(port) {
        q.clear();
    }
}

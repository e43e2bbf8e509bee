//! Functions `rtapi_shmem_…`: memory that components of one process share by a key.

use crate::second_setup::refuse_shared;
use core::ffi::{c_int, c_ulong, c_void};
use std::sync::{Mutex, PoisonError};

/// Shared memory block.
#[derive(Debug)]
struct Piece {
    key: c_int,
    users: u32,
    words: Box<[u64]>,
}

static PIECES: Mutex<Vec<Option<Piece>>> = Mutex::new(Vec::new());

fn index(id: c_int) -> Option<usize> {
    usize::try_from(id).ok()?.checked_sub(1)
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_shmem_new(key: c_int, _module: c_int, size: c_ulong) -> c_int {
    if let Some(refused) = refuse_shared("rtapi_shmem_new") {
        return refused;
    }
    let mut all = PIECES.lock().unwrap_or_else(PoisonError::into_inner);
    let words = usize::try_from(size.div_ceil(8)).unwrap_or(usize::MAX);
    let known = all.iter_mut().enumerate().find_map(|(i, p)| {
        let piece = p.as_mut().filter(|p| p.key == key)?;
        if piece.words.len() < words {
            return Some(-libc::EINVAL);
        }
        piece.users += 1;
        c_int::try_from(i + 1).ok()
    });
    if let Some(id) = known {
        return id;
    }
    if size == 0 || size > 1 << 30 {
        return -libc::ENOMEM;
    }
    let piece = Some(Piece { key, users: 1, words: vec![0; words].into() });
    let free = all.iter().position(Option::is_none).unwrap_or(all.len());
    if let Some(place) = all.get_mut(free) {
        *place = piece;
    } else {
        all.push(piece);
    }
    c_int::try_from(free + 1).unwrap_or(-libc::ENOMEM)
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_shmem_getptr(id: c_int, place: *mut *mut c_void) -> c_int {
    let mut all = PIECES.lock().unwrap_or_else(PoisonError::into_inner);
    let piece = index(id).and_then(|i| all.get_mut(i)).and_then(Option::as_mut);
    let Some(piece) = piece.filter(|_| !place.is_null()) else { return -libc::EINVAL };
    // SAFETY: the component's memory.
    unsafe { place.write(piece.words.as_mut_ptr().cast()) };
    0
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_shmem_delete(id: c_int, _module: c_int) -> c_int {
    let mut all = PIECES.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(place) = index(id).and_then(|i| all.get_mut(i)) else { return -libc::EINVAL };
    let Some(piece) = place else { return -libc::EINVAL };
    piece.users -= 1;
    if piece.users == 0 {
        *place = None;
    }
    0
}

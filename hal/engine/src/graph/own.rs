//! Access to values in a component's own memory.

use crate::sync::{AtomicU8, AtomicU32, AtomicU64, Ordering};
use core::{ffi::c_void, ptr::NonNull};
use hal_protocol::Type;

pub(crate) fn load(p: NonNull<c_void>, ty: Type) -> u64 {
    // Each load pairs with the stores of the component's functions, and with `store`.
    const LOAD: Ordering = Ordering::Acquire;
    match ty {
        // SAFETY: the component provided storage of this type, which lives as long as the
        // component.
        Type::Bit => u64::from(unsafe { p.cast::<AtomicU8>().as_ref() }.load(LOAD)),
        Type::S32 | Type::U32 | Type::Port => {
            // SAFETY: as above.
            u64::from(unsafe { p.cast::<AtomicU32>().as_ref() }.load(LOAD))
        }
        // SAFETY: as above.
        _ => unsafe { p.cast::<AtomicU64>().as_ref() }.load(LOAD),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "stored at exactly its width")]
pub(crate) fn store(p: NonNull<c_void>, ty: Type, bits: u64) {
    // Each store pairs with the loads of the component's functions, and with `load`.
    const STORE: Ordering = Ordering::Release;
    match ty {
        // SAFETY: the component provided storage of this type, which lives as long as the
        // component.
        Type::Bit => unsafe { p.cast::<AtomicU8>().as_ref() }.store(bits as u8, STORE),
        Type::S32 | Type::U32 | Type::Port => {
            // SAFETY: as above.
            unsafe { p.cast::<AtomicU32>().as_ref() }.store(bits as u32, STORE);
        }
        // SAFETY: as above.
        _ => unsafe { p.cast::<AtomicU64>().as_ref() }.store(bits, STORE),
    }
}

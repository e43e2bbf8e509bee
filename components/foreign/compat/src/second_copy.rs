//! Second copy of a module: its pins and parameters have memory of their own, filled with the values of the first copy's.

use core::{
    cell::RefCell,
    ffi::{c_int, c_void},
    sync::atomic::{
        AtomicPtr, AtomicU8, AtomicU32, AtomicU64,
        Ordering::{Acquire, Relaxed},
    },
};
use hal_component::abi::{ItemSpec, Status, ty};
use std::ffi::CString;

/// Pin or parameter that the first copy has requested.
#[derive(Debug)]
pub(crate) struct Made {
    pub(crate) name: String,
    pub(crate) ty: u8,
    pub(crate) from: FirstValue,
    /// Result of the request.
    pub(crate) status: Status,
}

/// Memory of a value in the first copy.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FirstValue {
    /// Pointer to the cell of a pin. The engine changes it with every link.
    Pin(*const AtomicPtr<AtomicU64>),
    /// Value of a parameter.
    Param(*const c_void),
}

/// Input of the second copy, and its source.
#[derive(Debug)]
pub(crate) struct Input {
    pub(crate) from: FirstValue,
    pub(crate) to: *mut c_void,
    pub(crate) ty: u8,
}

/// Items, components and refusals of the first copy's setup, for the setup of the second.
#[derive(Debug, Default)]
pub(crate) struct SecondCopy {
    /// Items that the second copy has not made yet.
    pub(crate) items: RefCell<Vec<Made>>,
    /// Further components: their numbers and names.
    pub(crate) further: Vec<(c_int, CString)>,
    refusals: Vec<String>,
    /// Inputs that the second copy has made so far.
    pub(crate) inputs: RefCell<Vec<Input>>,
}

impl Made {
    pub(crate) fn new(
        name: &str,
        spec: &ItemSpec,
        place: *mut *mut c_void,
        status: Status,
    ) -> Self {
        let from = if place.is_null() {
            FirstValue::Param(spec.storage)
        } else {
            FirstValue::Pin(place.cast_const().cast())
        };
        Self { name: name.to_owned(), ty: spec.ty, from, status }
    }
}

impl SecondCopy {
    pub(crate) fn new(
        items: Vec<Made>,
        further: Vec<(c_int, CString)>,
        refusals: Vec<String>,
    ) -> Self {
        Self { items: items.into(), further, refusals, inputs: RefCell::default() }
    }

    /// Returns the first refusal that the first copy did not get.
    pub(crate) fn refusal(&self, all: Vec<String>) -> Option<String> {
        all.into_iter().find(|why| !self.refusals.contains(why))
    }
}

impl Input {
    /// Copies the value of the first copy to the second.
    pub(crate) fn refresh(&self) {
        match self.from {
            FirstValue::Pin(pointer) => {
                // SAFETY: the first copy's memory, which stays as long as the second copy.
                let pointer = unsafe { &*pointer };
                // Acquire pairs with the Release of the engine's `point`, which links the pin.
                let cell = pointer.load(Acquire);
                // SAFETY: the cell of a pin or signal, in memory that stays mapped.
                let Some(cell) = (unsafe { cell.as_ref() }) else { return };
                // SAFETY: the second copy's cell, 8 bytes.
                unsafe { &*self.to.cast::<AtomicU64>() }.store(cell.load(Relaxed), Relaxed);
            }
            FirstValue::Param(from) => self.copy(from),
        }
    }

    fn copy(&self, from: *const c_void) {
        macro_rules! copy {
            ($atomic:ty) => {{
                // SAFETY: the first copy's value, aligned, of this width.
                let from = unsafe { &*from.cast::<$atomic>() };
                // SAFETY: the second copy's value, aligned, of this width.
                let to = unsafe { &*self.to.cast::<$atomic>() };
                to.store(from.load(Relaxed), Relaxed);
            }};
        }
        match self.ty {
            ty::BIT => copy!(AtomicU8),
            ty::S32 | ty::U32 => copy!(AtomicU32),
            _ => copy!(AtomicU64),
        }
    }
}

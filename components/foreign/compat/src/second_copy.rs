//! Pins and parameters of a module's second copy: memory of its own, filled with the values of the first copy.

use core::{
    cell::RefCell,
    ffi::c_void,
    sync::atomic::{AtomicPtr, AtomicU8, AtomicU32, AtomicU64, Ordering::Relaxed},
};
use hal_component::abi::{dir, ty};

/// Pin or parameter to be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ItemRequest<'n> {
    /// Name with the prefix.
    pub(crate) name: &'n str,
    pub(crate) ty: u8,
    pub(crate) dir: u8,
    /// Bits of its first value.
    pub(crate) initial: u64,
    /// Memory of a parameter's value.
    pub(crate) storage: *mut c_void,
    /// Memory of a pin's pointer to its cell.
    pub(crate) place: *mut *mut c_void,
}

/// Pin or parameter that the first copy has made.
#[derive(Debug)]
pub(crate) struct Made {
    name: String,
    ty: u8,
    from: FirstValue,
}

/// Memory of a value in the first copy.
#[derive(Clone, Copy, Debug)]
enum FirstValue {
    /// Pointer to the cell of a pin. The engine changes it with every link.
    Pin(*const AtomicPtr<AtomicU64>),
    /// Value of a parameter.
    Param(*const c_void),
}

impl Made {
    pub(crate) fn new(item: &ItemRequest<'_>) -> Self {
        let from = if item.place.is_null() {
            FirstValue::Param(item.storage)
        } else {
            FirstValue::Pin(item.place.cast_const().cast())
        };
        Self { name: item.name.to_owned(), ty: item.ty, from }
    }
}

/// Input of the second copy, and its source.
#[derive(Debug)]
pub(crate) struct Input {
    from: FirstValue,
    to: *mut c_void,
    ty: u8,
}

/// Items of the first copy, and the inputs that the second one has made so far.
#[derive(Debug)]
pub(crate) struct Mirror {
    first: Vec<Made>,
    pub(crate) inputs: RefCell<Vec<Input>>,
}

impl Mirror {
    pub(crate) const fn new(first: Vec<Made>) -> Self {
        Self { first, inputs: RefCell::new(Vec::new()) }
    }

    /// Gives the second copy an item of the first; `cell` are 8 bytes for the value of a pin. Returns false if the first
    /// copy has no such item.
    pub(crate) fn make(&self, item: &ItemRequest<'_>, cell: *mut u64) -> bool {
        let found = self.first.iter().find(|m| m.name == item.name && m.ty == item.ty);
        let Some(first) = found else { return false };
        let to = if item.place.is_null() {
            item.storage
        } else {
            // SAFETY: the caller's cell.
            unsafe { cell.write(item.initial) };
            // SAFETY: the module's memory for a pointer, which the caller has checked.
            unsafe { item.place.write(cell.cast()) };
            cell.cast()
        };
        let is_input = [dir::IN, dir::IO, dir::RW].contains(&item.dir);
        if is_input && item.ty != ty::PORT {
            self.inputs.borrow_mut().push(Input { from: first.from, to, ty: item.ty });
        }
        true
    }
}

impl Input {
    /// Copies the value of the first copy to the second.
    pub(crate) fn refresh(&self) {
        match self.from {
            FirstValue::Pin(pointer) => {
                // SAFETY: the first copy's memory, which stays as long as the second copy.
                let cell = unsafe { &*pointer }.load(Relaxed);
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

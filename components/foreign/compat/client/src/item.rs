//! Value of a C program: its memory, and its state in the instance.

use core::ffi::c_void;
use hal_protocol::{Direction, Type, Value};
use std::{
    ffi::c_int,
    sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering},
};

/// Pin, or parameter, which is a pin for the instance.
#[derive(Debug)]
pub(crate) struct Item {
    pub(crate) ty: Type,
    pub(crate) direction: Direction,
    pub(crate) cell: Cell,
    /// Last value that program and instance agreed on.
    pub(crate) agreed: u64,
}

impl Item {
    /// Makes an item from C's codes of type and direction. Its value has no memory yet.
    pub(crate) fn new(ty: c_int, dir: c_int) -> Option<Self> {
        let ty = match ty {
            1 => Type::Bit,
            2 => Type::Float,
            3 => Type::S32,
            4 => Type::U32,
            6 => Type::S64,
            7 => Type::U64,
            _ => return None,
        };
        let direction = match dir {
            16 | 192 => Direction::In,
            32 | 64 => Direction::Out,
            48 => Direction::Io,
            _ => return None,
        };
        Some(Self { ty, direction, cell: Cell::new(0), agreed: 0 })
    }

    /// Returns the new value if the program has written one since the last exchange.
    pub(crate) fn written(&mut self) -> Option<Value> {
        let bits = self.cell.load(self.ty);
        if matches!(self.direction, Direction::In) || bits == self.agreed {
            return None;
        }
        self.agreed = bits;
        Some(Value::from_bits(self.ty, bits))
    }

    /// Takes over the instance's value.
    pub(crate) fn read(&mut self, value: &Value) {
        let bits = value.bits();
        let mine = self.cell.load(self.ty);
        match self.direction {
            Direction::In if mine != bits => self.cell.store(bits),
            // If the program has written the value meanwhile, that value is sent first.
            Direction::Io if mine == self.agreed => {
                self.cell.store(bits);
                self.agreed = bits;
            }
            _ => {}
        }
    }
}

/// Memory of a value, by its width.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cell {
    Narrow(&'static AtomicU8),
    Half(&'static AtomicU32),
    Whole(&'static AtomicU64),
}

impl Cell {
    /// Allocates memory that lives as long as the process.
    pub(crate) fn new(initial: u64) -> Self {
        Self::Whole(Box::leak(Box::new(AtomicU64::new(initial))))
    }

    /// Uses the memory of a parameter.
    ///
    /// # Safety
    /// The memory is the program's, aligned and as wide as its type, and is never freed.
    pub(crate) unsafe fn at(at: *mut c_void, ty: Type) -> Self {
        match ty {
            // SAFETY: guaranteed by the caller.
            Type::Bit => Self::Narrow(unsafe { AtomicU8::from_ptr(at.cast()) }),
            // SAFETY: guaranteed by the caller.
            Type::S32 | Type::U32 => Self::Half(unsafe { AtomicU32::from_ptr(at.cast()) }),
            Type::Float | Type::S64 | Type::U64 | Type::Port => {
                // SAFETY: guaranteed by the caller.
                Self::Whole(unsafe { AtomicU64::from_ptr(at.cast()) })
            }
        }
    }

    pub(crate) const fn address(self) -> *mut c_void {
        match self {
            Self::Narrow(cell) => cell.as_ptr().cast(),
            Self::Half(cell) => cell.as_ptr().cast(),
            Self::Whole(cell) => cell.as_ptr().cast(),
        }
    }

    /// Reads the value in the instance's form. Relaxed, because C code orders nothing by a single value.
    pub(crate) fn load(self, ty: Type) -> u64 {
        let bits = match self {
            Self::Narrow(cell) => u64::from(cell.load(Ordering::Relaxed)),
            Self::Half(cell) => u64::from(cell.load(Ordering::Relaxed)),
            Self::Whole(cell) => cell.load(Ordering::Relaxed),
        };
        // A pin has eight bytes, of which C writes as many as its type has.
        match ty {
            Type::Bit => u64::from(bits & 0xff != 0),
            Type::S32 | Type::U32 => bits & 0xffff_ffff,
            Type::Float | Type::S64 | Type::U64 | Type::Port => bits,
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "the value lives in the low part")]
    pub(crate) fn store(self, bits: u64) {
        match self {
            Self::Narrow(cell) => cell.store(bits as u8, Ordering::Relaxed),
            Self::Half(cell) => cell.store(bits as u32, Ordering::Relaxed),
            Self::Whole(cell) => cell.store(bits, Ordering::Relaxed),
        }
    }
}

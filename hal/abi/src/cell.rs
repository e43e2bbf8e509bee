//! Realtime. Storage of values: cells, and the slots through which pins read and write.

use core::sync::atomic::{
    AtomicI32, AtomicU64,
    Ordering::{Acquire, Release},
};

/// A HAL value of 64 bits that is always read and written as a whole.
#[repr(transparent)]
#[derive(Debug, Default)]
pub struct Cell(AtomicU64);

impl Cell {
    /// Returns a cell that holds `bits`.
    pub const fn new(bits: u64) -> Self {
        Self(AtomicU64::new(bits))
    }

    /// Reads the value.
    #[inline]
    pub fn load(&self) -> u64 {
        self.0.load(Acquire) // Pairs with `store` in the writer of the pin.
    }

    /// Writes the value.
    #[inline]
    pub fn store(&self, bits: u64) {
        self.0.store(bits, Release); // Pairs with `load` in every reader of the pin.
    }
}

/// Access of a pin to its value: its own cell, or the cell of the signal that it is linked to.
///
/// `target` is a byte distance from the slot itself, so a slot is valid at every address to which
/// the arena is mapped.
#[repr(C)]
#[derive(Debug)]
pub struct Slot {
    target: AtomicI32,
    reserved: u32,
    own: Cell,
}

const _: () = assert!(core::mem::offset_of!(Slot, own) == 8 && size_of::<Slot>() == 16);

impl Slot {
    /// Byte distance from the slot to its own cell.
    pub const OWN: i32 = 8;

    /// Returns an unlinked slot whose own cell holds `bits`.
    pub const fn unlinked(bits: u64) -> Self {
        Self { target: AtomicI32::new(Self::OWN), reserved: 0, own: Cell::new(bits) }
    }

    /// Points the slot at the cell `distance` bytes away.
    #[inline]
    pub fn aim(&self, distance: i32) {
        self.target.store(distance, Release); // Pairs with `cell`.
    }

    /// Returns the slot's own cell, even if the slot is linked.
    pub const fn own(&self) -> &Cell {
        &self.own
    }

    /// Returns the cell that the slot points at.
    ///
    /// # Safety
    /// `slot` must point into a live arena, with provenance over the whole arena, and `target` must
    /// have been set by that arena.
    #[inline]
    pub unsafe fn cell<'a>(slot: *const Self) -> &'a Cell {
        // SAFETY: the caller guarantees that `slot` is live.
        let distance = unsafe { &(*slot).target }.load(Acquire); // Pairs with `aim`.
        // SAFETY: the arena keeps every target inside itself.
        let cell = unsafe { slot.byte_offset(distance as isize) }.cast::<Cell>();
        // SAFETY: the arena puts a live, aligned cell at every target.
        unsafe { &*cell }
    }
}

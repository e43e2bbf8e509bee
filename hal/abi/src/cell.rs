//! Realtime. Where values live: cells, and the slots that pins read and write through.

use core::sync::atomic::{
    AtomicI32, AtomicU64,
    Ordering::{Acquire, Release},
};

/// One HAL value: 64 bits read and written whole.
#[repr(transparent)]
#[derive(Debug, Default)]
pub struct Cell(AtomicU64);

impl Cell {
    /// A cell holding `bits`.
    pub const fn new(bits: u64) -> Self {
        Self(AtomicU64::new(bits))
    }

    /// Reads the value.
    #[inline]
    pub fn load(&self) -> u64 {
        self.0.load(Acquire) // Pairs with `store` by whoever writes the pin.
    }

    /// Writes the value.
    #[inline]
    pub fn store(&self, bits: u64) {
        self.0.store(bits, Release); // Pairs with `load` by whoever reads the pin.
    }
}

/// Where a pin reads and writes: its own cell, or the cell of the signal it is linked to.
///
/// `target` is a byte distance from the slot itself, so the same slot is valid wherever the
/// arena is mapped.
#[repr(C)]
#[derive(Debug)]
pub struct Slot {
    target: AtomicI32,
    reserved: u32,
    own: Cell,
}

const _: () = assert!(core::mem::offset_of!(Slot, own) == 8 && size_of::<Slot>() == 16);

impl Slot {
    /// Byte distance to the slot's own cell.
    pub const OWN: i32 = 8;

    /// An unlinked slot whose own cell holds `bits`.
    pub const fn unlinked(bits: u64) -> Self {
        Self { target: AtomicI32::new(Self::OWN), reserved: 0, own: Cell::new(bits) }
    }

    /// Points the slot at the cell `distance` bytes away.
    #[inline]
    pub fn aim(&self, distance: i32) {
        self.target.store(distance, Release); // Pairs with `cell`.
    }

    /// The slot's own cell, linked or not.
    pub const fn own(&self) -> &Cell {
        &self.own
    }

    /// The cell this slot is aimed at.
    ///
    /// # Safety
    /// `slot` points into a live arena, with provenance over the whole arena, and `target` was
    /// set by that arena.
    #[inline]
    pub unsafe fn cell<'a>(slot: *const Self) -> &'a Cell {
        // SAFETY: `slot` is live per the caller.
        let distance = unsafe { &(*slot).target }.load(Acquire); // Pairs with `aim`.
        // SAFETY: the arena keeps every target inside itself.
        let cell = unsafe { slot.byte_offset(distance as isize) }.cast::<Cell>();
        // SAFETY: the arena puts a live, aligned cell at every target.
        unsafe { &*cell }
    }
}

//! Memory for slots and signal cells: 2 GiB of address space, committed in chunks and never moved.

use crate::{Error, graph::ptr::Ptr, os};
use core::ptr::NonNull;
use hal_abi::{Cell, Slot};
use std::collections::BTreeSet;

const RESERVED: usize = 1 << 31;
const CHUNK: usize = 1 << 20;

/// The arena. A slot stores the distance to its cell in 32 bits, so the arena is at most 2 GiB
/// long.
#[derive(Debug)]
pub(crate) struct Arena {
    base: NonNull<u8>,
    committed: usize,
    used: usize,
    lock: bool,
    left: bool,
    free_slots: Vec<NonNull<Slot>>,
    free_cells: Vec<NonNull<Cell>>,
    /// True while there is a mark. `taken_slots` and `taken_cells` are those reused from the free
    /// lists since then.
    marked: bool,
    taken_slots: Vec<NonNull<Slot>>,
    taken_cells: Vec<NonNull<Cell>>,
}

/// State of the arena's allocations. The arena can return to it and free everything allocated
/// since.
#[derive(Debug)]
pub(crate) struct Mark {
    used: usize,
    slots: usize,
    cells: usize,
}

impl Arena {
    /// Reserves the address space. `lock` requests locked memory, which never causes page faults.
    pub(crate) fn new(lock: bool) -> Result<Self, Error> {
        let base = os::reserve(RESERVED).ok_or(Error::OutOfMemory)?;
        Ok(Self {
            base,
            committed: 0,
            used: 64,
            lock,
            left: false,
            free_slots: Vec::new(),
            free_cells: Vec::new(),
            marked: false,
            taken_slots: Vec::new(),
            taken_cells: Vec::new(),
        })
    }

    /// Returns the number of bytes in use and the number of bytes reserved.
    pub(crate) fn usage(&self) -> (u64, u64) {
        let free = self.free_slots.len() * size_of::<Slot>() + self.free_cells.len() * 8;
        ((self.used - free) as u64, RESERVED as u64)
    }

    /// Returns the numbers of free slots and free cells that were used before.
    pub(crate) const fn recycled(&self) -> (usize, usize) {
        (self.free_slots.len(), self.free_cells.len())
    }

    /// Records the current allocations. Until [`Self::keep`] or [`Self::roll_back`] is called, only
    /// slots and cells allocated since the mark may be freed.
    pub(crate) const fn mark(&mut self) -> Mark {
        self.marked = true;
        Mark { used: self.used, slots: self.free_slots.len(), cells: self.free_cells.len() }
    }

    /// Returns the addresses allocated since the mark: the range at the end, and the reused places.
    pub(crate) fn since(&self, mark: &Mark) -> (core::ops::Range<usize>, BTreeSet<usize>) {
        let base = self.base.addr().get();
        let mut again: BTreeSet<usize> = self.taken_cells.iter().map(|c| c.addr().get()).collect();
        for slot in &self.taken_slots {
            let own = crate::graph::ptr::own_cell(Ptr(*slot));
            again.extend([slot.addr().get(), own.0.addr().get()]);
        }
        (base + mark.used..base + self.used, again)
    }

    /// Keeps everything allocated since the mark.
    pub(crate) fn keep(&mut self, mark: Mark) {
        let Mark { .. } = mark;
        self.marked = false;
        self.taken_slots.clear();
        self.taken_cells.clear();
    }

    /// Frees everything allocated since the mark and restores the arena's state at the mark.
    pub(crate) fn roll_back(&mut self, mark: Mark) {
        self.used = mark.used;
        // Slots and cells that were freed since the mark were also allocated since then.
        self.free_slots.truncate(mark.slots - self.taken_slots.len());
        self.free_slots.extend(self.taken_slots.drain(..).rev());
        self.free_cells.truncate(mark.cells - self.taken_cells.len());
        self.free_cells.extend(self.taken_cells.drain(..).rev());
        self.marked = false;
    }

    /// Unlocks the address space that has no memory yet.
    pub(crate) fn unlock_rest(&self) {
        // SAFETY: `committed` is below the end of the reservation.
        let rest = unsafe { self.base.add(self.committed) };
        os::memory::unlock(rest, RESERVED - self.committed);
    }

    /// Keeps the memory mapped for the rest of the process, because a thread that cannot be ended
    /// may still use it.
    pub(crate) const fn leave(&mut self) {
        self.left = true;
    }

    fn place(&mut self, bytes: usize) -> Result<NonNull<u8>, Error> {
        let end = self.used + bytes;
        if end > RESERVED {
            return Err(Error::OutOfMemory);
        }
        while end > self.committed {
            // SAFETY: `committed` is below the end of the reservation.
            let at = unsafe { self.base.add(self.committed) };
            if !os::commit(at, CHUNK, self.lock) {
                return Err(Error::OutOfMemory);
            }
            self.committed += CHUNK;
        }
        // SAFETY: `used` is below the end of the reservation.
        let at = unsafe { self.base.add(self.used) };
        self.used = end;
        Ok(at)
    }

    /// Allocates an unlinked slot.
    pub(crate) fn slot(&mut self, bits: u64) -> Result<NonNull<Slot>, Error> {
        if let Some(slot) = self.free_slots.pop() {
            if self.marked {
                self.taken_slots.push(slot);
            }
            // SAFETY: the slot belongs to this arena and nobody uses it.
            let s = unsafe { slot.as_ref() };
            s.own().store(bits);
            s.aim(Slot::OWN);
            return Ok(slot);
        }
        self.used = self.used.next_multiple_of(align_of::<Slot>());
        let slot = self.place(size_of::<Slot>())?.cast::<Slot>();
        // SAFETY: the pointer is in bounds and aligned, and the memory is not used yet.
        unsafe { slot.write(Slot::unlinked(bits)) };
        Ok(slot)
    }

    /// Allocates a cell for a signal.
    pub(crate) fn cell(&mut self, bits: u64) -> Result<NonNull<Cell>, Error> {
        if let Some(cell) = self.free_cells.pop() {
            if self.marked {
                self.taken_cells.push(cell);
            }
            // SAFETY: the cell belongs to this arena and nobody uses it.
            unsafe { cell.as_ref() }.store(bits);
            return Ok(cell);
        }
        let cell = self.place(size_of::<Cell>())?.cast::<Cell>();
        // SAFETY: the pointer is in bounds and aligned, and the memory is not used yet.
        unsafe { cell.write(Cell::new(bits)) };
        Ok(cell)
    }

    /// Frees a slot that nobody uses any more.
    pub(crate) fn give_slot(&mut self, slot: NonNull<Slot>) {
        self.free_slots.push(slot);
    }

    /// Frees a cell that no slot points at any more.
    pub(crate) fn give_cell(&mut self, cell: NonNull<Cell>) {
        self.free_cells.push(cell);
    }

    /// Returns the distance in bytes from a slot to a cell.
    pub(crate) fn distance(slot: NonNull<Slot>, cell: NonNull<Cell>) -> i32 {
        let far = cell.as_ptr().addr().cast_signed() - slot.as_ptr().addr().cast_signed();
        i32::try_from(far).unwrap_or(Slot::OWN)
    }
}

impl Drop for Arena {
    fn drop(&mut self) {
        if self.left {
            return;
        }
        // SAFETY: the address space was reserved in `new`, and the engine drops the arena last.
        unsafe { os::release(self.base, RESERVED) };
    }
}

#[cfg(test)]
mod tests {
    use super::Arena;
    use core::ptr::NonNull;
    use hal_abi::Slot;

    #[test]
    fn a_slot_reads_the_cell_it_is_aimed_at() {
        let mut arena = Arena::new(false).unwrap();
        let slots: Vec<_> = (0..100_000).map(|i| arena.slot(i).unwrap()).collect();
        let cell = arena.cell(7).unwrap();
        let first = slots[0];
        // SAFETY: the slots belong to a live arena.
        let read = |slot: NonNull<Slot>| unsafe { Slot::cell(slot.as_ptr()) }.load();
        // SAFETY: as above.
        let aim = |distance| unsafe { first.as_ref() }.aim(distance);
        aim(Arena::distance(first, cell));
        assert_eq!(read(first), 7);
        aim(Slot::OWN);
        assert_eq!(read(first), 0);
        assert_eq!(read(slots[99_999]), 99_999);
        let used = arena.usage().0;
        arena.give_slot(first);
        assert_eq!(arena.slot(1).unwrap(), first);
        assert_eq!(arena.usage().0, used);
    }

    #[test]
    fn what_is_new_since_a_mark_is_given_back_at_once() {
        let mut arena = Arena::new(false).unwrap();
        let old: Vec<_> = (0..5).map(|_| arena.slot(0).unwrap()).collect();
        let cell = arena.cell(1).unwrap();
        old[..3].iter().for_each(|slot| arena.give_slot(*slot));
        arena.give_cell(cell);
        let before = (arena.usage(), arena.recycled(), arena.free_slots.clone());
        let mark = arena.mark();
        let again = arena.slot(0).unwrap();
        let new: Vec<_> = (0..7).map(|_| arena.slot(0).unwrap()).collect();
        let cells = [arena.cell(2).unwrap(), arena.cell(3).unwrap()];
        let (end, places) = arena.since(&mark);
        let is_new = |at: usize| end.contains(&at) || places.contains(&at);
        assert!(is_new(again.addr().get()) && is_new(new[6].addr().get()));
        assert!(is_new(cells[0].addr().get()) && is_new(cells[1].addr().get()));
        assert!(!is_new(old[4].addr().get()));
        arena.give_slot(new[0]);
        arena.roll_back(mark);
        assert_eq!((arena.usage(), arena.recycled(), arena.free_slots.clone()), before);
        let mark = arena.mark();
        arena.slot(0).unwrap();
        arena.keep(mark);
        assert_eq!(arena.recycled(), (2, 1));
    }
}

//! Memory that components allocate: zeroed, and owned by the component until it is unloaded.

use std::{
    alloc::{Layout, alloc_zeroed, dealloc},
    sync::{Mutex, PoisonError},
};

/// Memory blocks of one module.
#[derive(Debug, Default)]
pub(crate) struct Memory(Mutex<Vec<Block>>);

#[derive(Debug)]
struct Block {
    at: *mut u8,
    layout: Layout,
}

// SAFETY: the addresses belong to the component; here they are only compared and freed.
unsafe impl Send for Block {}

impl Memory {
    /// Allocates a zeroed block, aligned for every type.
    pub(crate) fn take(&self, bytes: usize) -> Option<*mut u8> {
        let layout = Layout::from_size_align(bytes.max(8).next_multiple_of(16), 64).ok()?;
        // SAFETY: the size is not zero.
        let at = unsafe { alloc_zeroed(layout) };
        if at.is_null() {
            return None;
        }
        // Touches the pages now, and not in a realtime function.
        // SAFETY: within the block.
        unsafe { at.write_bytes(0, layout.size()) };
        self.blocks().push(Block { at, layout });
        Some(at)
    }

    /// Returns whether all of `bytes` at `place` lie in one block.
    pub(crate) fn holds(&self, place: usize, bytes: usize) -> bool {
        self.blocks().iter().any(|b| {
            let begin = b.at.addr();
            place >= begin && place.saturating_add(bytes) <= begin + b.layout.size()
        })
    }

    fn blocks(&self) -> std::sync::MutexGuard<'_, Vec<Block>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Frees all blocks; the component no longer runs.
    pub(crate) fn free(&self) {
        for b in self.blocks().drain(..) {
            // SAFETY: allocated in `take` with this layout, freed once.
            unsafe { dealloc(b.at, b.layout) };
        }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        self.free();
    }
}

#[cfg(test)]
mod tests {
    use super::Memory;

    #[test]
    fn blocks_are_zero_and_known() {
        let memory = Memory::default();
        let at = memory.take(24).unwrap();
        // SAFETY: a block of 24 bytes.
        assert!(unsafe { core::slice::from_raw_parts(at, 24) }.iter().all(|b| *b == 0));
        assert!(memory.holds(at.addr(), 8) && memory.holds(at.addr() + 16, 8));
        assert!(!memory.holds(at.addr() + 32, 8) && !memory.holds(8, 8));
    }
}

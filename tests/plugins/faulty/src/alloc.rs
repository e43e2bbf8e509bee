//! `alloc`.
use hal_component::{Component, In, Out, Period, Update};

/// Allocates in a cycle, which no function may.
#[derive(Component)]
pub(crate) struct Alloc {
    /// While true each cycle allocates and frees.
    go: In<bool>,
    /// Number of allocations.
    times: Out<u32>,
}

impl Update for Alloc {
    fn update(&mut self, _: Period) {
        if self.go.get() {
            let list: Vec<u32> = (0..self.times.get() % 7 + 1).collect();
            self.times.set(self.times.get().wrapping_add(1));
            drop(core::hint::black_box(list));
        }
    }
}

//! `deep`: a function that needs much stack.
use hal_component::{Component, In, Out, Period, Update};
use std::hint::black_box;

/// Uses as much stack as it is told to.
#[derive(Component)]
pub(crate) struct Deep {
    /// How many KiB of stack each cycle uses.
    kib: In<u32>,
    /// How many the last cycle used.
    used: Out<u32>,
}

impl Update for Deep {
    fn update(&mut self, _: Period) {
        self.used.set(down(self.kib.get()));
    }
}

/// A frame of a KiB for each that is left.
#[inline(never)]
fn down(left: u32) -> u32 {
    let mut room = [0_u8; 1024];
    black_box(&mut room);
    let used = if left == 0 { 0 } else { down(left - 1) + 1 };
    black_box(&mut room);
    used
}

//! `deep`: a function that needs much stack.
use hal_component::{Component, In, Out, Period, Update};
use std::hint::black_box;

/// Uses a requested amount of stack.
#[derive(Component)]
pub(crate) struct Deep {
    /// Stack that each cycle uses, in KiB.
    kib: In<u32>,
    /// Stack that the last cycle used, in KiB.
    used: Out<u32>,
}

impl Update for Deep {
    fn update(&mut self, _: Period) {
        self.used.set(down(self.kib.get()));
    }
}

/// Uses a stack frame of 1 KiB for each remaining KiB.
#[inline(never)]
fn down(left: u32) -> u32 {
    let mut room = [0_u8; 1024];
    black_box(&mut room);
    let used = if left == 0 { 0 } else { down(left - 1) + 1 };
    black_box(&mut room);
    used
}

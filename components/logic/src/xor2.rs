//! `xor2`.
use hal_component::{Component, In, Out, Period, Update};

/// Two-input XOR gate.
#[derive(Component)]
pub(crate) struct Xor2 {
    /// First input.
    in0: In<bool>,
    /// Second input.
    in1: In<bool>,
    /// True when exactly one input is.
    out: Out<bool>,
}

impl Update for Xor2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() != self.in1.get());
    }
}

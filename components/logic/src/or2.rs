//! `or2`.
use hal_component::{Component, In, Out, Period, Update};

/// Two-input OR gate.
#[derive(Component)]
pub(crate) struct Or2 {
    /// First input.
    in0: In<bool>,
    /// Second input.
    in1: In<bool>,
    /// True when at least one input is.
    out: Out<bool>,
}

impl Update for Or2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() || self.in1.get());
    }
}

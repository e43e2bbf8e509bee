//! `and2`.
use hal_component::{Component, In, Out, Period, Update};

/// Two-input AND gate.
#[derive(Component)]
pub(crate) struct And2 {
    /// First input.
    in0: In<bool>,
    /// Second input.
    in1: In<bool>,
    /// True when both inputs are.
    out: Out<bool>,
}

impl Update for And2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() && self.in1.get());
    }
}

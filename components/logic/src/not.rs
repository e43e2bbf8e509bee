//! `not`.
use hal_component::{Component, In, Out, Period, Update};

/// Inverter.
#[derive(Component)]
pub(crate) struct Not {
    /// Input.
    in_: In<bool>,
    /// True when the input is false.
    out: Out<bool>,
}

impl Update for Not {
    fn update(&mut self, _: Period) {
        self.out.set(!self.in_.get());
    }
}

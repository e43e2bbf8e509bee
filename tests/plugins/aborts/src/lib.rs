//! A plugin like any other, but built with `panic=abort` (profile `abort`).
use hal_component::{Component, Out, Period, Update};

/// Does nothing wrong, and would end the machine's process if it did.
#[derive(Component)]
struct Aborts {
    /// Always true.
    out: Out<bool>,
}

impl Update for Aborts {
    fn update(&mut self, _: Period) {
        self.out.set(true);
    }
}

hal_component::export!(Aborts);

//! `or2`.
use hal_component::{Component, In, Out, Period, Update};

/// Two-input OR gate.
///
/// # Example
///
/// ```hal
/// loadrt or2
/// loadrt threads name1=servo period1=1000000
/// addf or2.0 servo
/// start
/// run 1ms
/// getp or2.0.out # -> FALSE
/// setp or2.0.in1 1
/// run 1ms
/// getp or2.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Or2 {
    /// First input.
    in0: In<bool>,
    /// Second input.
    in1: In<bool>,
    /// True when at least one input is true.
    out: Out<bool>,
}

impl Update for Or2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() || self.in1.get());
    }
}

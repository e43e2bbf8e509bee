//! `and2`.
use hal_component::{Component, In, Out, Period, Update};

/// Two-input AND gate.
///
/// # Example
///
/// ```hal
/// loadrt and2
/// loadrt threads name1=servo period1=1000000
/// addf and2.0 servo
/// start
/// setp and2.0.in0 1
/// run 1ms
/// getp and2.0.out # -> FALSE
/// setp and2.0.in1 1
/// run 1ms
/// getp and2.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct And2 {
    /// First input.
    in0: In<bool>,
    /// Second input.
    in1: In<bool>,
    /// True when both inputs are true.
    out: Out<bool>,
}

impl Update for And2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() && self.in1.get());
    }
}

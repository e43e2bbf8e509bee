//! `xor2`.
use hal_component::{Component, In, Out, Period, Update};

/// Two-input XOR gate.
///
/// # Example
///
/// ```hal
/// loadrt xor2
/// loadrt threads name1=servo period1=1000000
/// addf xor2.0 servo
/// start
/// setp xor2.0.in0 1
/// run 1ms
/// getp xor2.0.out # -> TRUE
/// setp xor2.0.in1 1
/// run 1ms
/// getp xor2.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Xor2 {
    /// First input.
    in0: In<bool>,
    /// Second input.
    in1: In<bool>,
    /// True when exactly one input is true.
    out: Out<bool>,
}

impl Update for Xor2 {
    fn update(&mut self, _: Period) {
        self.out.set(self.in0.get() != self.in1.get());
    }
}

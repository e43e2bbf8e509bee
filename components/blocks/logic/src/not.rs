//! `not`.
use hal_component::{Component, In, Out, Period, Update};

/// Inverter.
///
/// # Example
///
/// ```hal
/// loadrt not
/// loadrt threads name1=servo period1=1000000
/// addf not.0 servo
/// start
/// run 1ms
/// getp not.0.out # -> TRUE
/// setp not.0.in 1
/// run 1ms
/// getp not.0.out # -> FALSE
/// ```
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

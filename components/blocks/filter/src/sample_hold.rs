//! `sample_hold`.
use hal_component::{Component, In, Out, Period, Update};

/// Sample and hold for a number.
///
/// # Example
///
/// ```hal
/// loadrt sample_hold
/// loadrt threads name1=servo period1=1000000
/// addf sample-hold.0 servo
/// start
/// setp sample-hold.0.in 5
/// run 1ms
/// setp sample-hold.0.hold 1
/// setp sample-hold.0.in 9
/// run 1ms
/// getp sample-hold.0.out # -> 5
/// setp sample-hold.0.hold 0
/// run 1ms
/// getp sample-hold.0.out # -> 9
/// ```
#[derive(Component)]
pub(crate) struct SampleHold {
    /// Input number.
    in_: In<i32>,
    /// While true, the output keeps its value.
    hold: In<bool>,
    /// Input when it was last not held.
    out: Out<i32>,
}

impl Update for SampleHold {
    fn update(&mut self, _: Period) {
        if !self.hold.get() {
            self.out.set(self.in_.get());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::SampleHold;
    use hal_bench::trace::replay;

    #[test]
    fn held_and_followed() {
        let rows = replay::<SampleHold>(
            "load sample_hold
             run sample-hold.0
             in sample-hold.0.in sample-hold.0.hold
             out sample-hold.0.out
             7 1 | 0
             7 0 | 7
             -2147483648 1 | 7
             . 0 | -2147483648",
        );
        assert_eq!(rows, 4);
    }
}

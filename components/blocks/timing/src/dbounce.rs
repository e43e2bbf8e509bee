//! `dbounce`.
use hal_component::{Component, In, Out, Period, Update};

/// Debounce filter for a switch.
///
/// A counter counts up in each cycle with the input true and down in each cycle with it false. The output changes when
/// the counter would leave its range, from zero to `delay`. Unlike `debounce`, this component has no groups: each
/// instance has its own delay.
///
/// # Example
///
/// ```hal
/// loadrt dbounce
/// loadrt threads name1=servo period1=1000000
/// addf dbounce.0 servo
/// start
/// setp dbounce.0.in 1
/// run 5ms
/// getp dbounce.0.out # -> FALSE
/// run 1ms
/// getp dbounce.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Dbounce {
    /// Bouncing input.
    in_: In<bool>,
    /// Debounced output.
    out: Out<bool>,
    /// Number of cycles, beyond the first, for which the input must hold before the output follows.
    #[hal(default = 5)]
    delay: In<u32>,
    #[state]
    count: u32,
}

impl Update for Dbounce {
    fn update(&mut self, _: Period) {
        if self.in_.get() {
            if self.count < self.delay.get() {
                self.count += 1;
            } else {
                self.out.set(true);
            }
        } else if self.count > 0 {
            self.count -= 1;
        } else {
            self.out.set(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Dbounce;
    use hal_bench::trace::replay;

    #[test]
    fn it_must_hold() {
        let rows = replay::<Dbounce>(
            "load dbounce
             set dbounce.0.delay 2
             run dbounce.0
             in dbounce.0.in
             out dbounce.0.out
             1 | 0
             0 | 0
             1 | 0
             1 | 0
             1 | 1
             0 | 1
             1 | 1
             0 | 1
             0 | 1
             0 | 0
             set dbounce.0.delay 0
             1 | 1
             0 | 0",
        );
        assert_eq!(rows, 12);
    }
}

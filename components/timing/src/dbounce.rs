//! `dbounce`.
use hal_component::{Component, In, Out, Period, Update};

/// Filter for a switch that bounces.
///
/// It counts up at each run with its input true and down at each run with it false; its output
/// changes when the count would leave its range, from zero to `delay`. Unlike `debounce` it has no
/// groups: each instance has a delay of its own.
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
    /// The bouncing bit.
    in_: In<bool>,
    /// The steady bit.
    out: Out<bool>,
    /// How many runs the input must hold, beyond the first, for the output to follow.
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
    use hal_component::trace::replay;

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

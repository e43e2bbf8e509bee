//! `safety_latch`.
use hal_component::{Component, In, Out, Period, Update};

/// Latch for an error that must last, or occur often enough, to count.
///
/// Each cycle with the error adds `harm` to a count, each cycle without it subtracts `heal`. When the count reaches
/// `threshold`, the outputs report the error: until a reset if `latching` is true, otherwise until the count has
/// returned to `min`.
///
/// # Example
///
/// ```hal
/// # An error counts after three runs, and is forgiven five times as slowly.
/// loadrt safety_latch
/// loadrt threads name1=servo period1=1000000
/// addf safety-latch.0 servo
/// start
/// setp safety-latch.0.harm 5
/// setp safety-latch.0.threshold 15
/// setp safety-latch.0.error-in 1
/// run 2ms
/// getp safety-latch.0.count # -> 10
/// getp safety-latch.0.ok-out # -> TRUE
/// run 1ms
/// getp safety-latch.0.ok-out # -> FALSE
/// setp safety-latch.0.error-in 0
/// run 1s
/// getp safety-latch.0.count # -> 0
/// getp safety-latch.0.ok-out # -> FALSE
/// setp safety-latch.0.reset 1
/// run 1ms
/// getp safety-latch.0.ok-out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct SafetyLatch {
    /// Error input.
    error_in: In<bool>,
    /// While false, errors are not counted, and the outputs report no error.
    #[hal(default = true)]
    enable: In<bool>,
    /// Rising edge sets the count to `min` and ends a latched error.
    reset: In<bool>,
    /// TRUE: an error lasts until a reset.
    #[hal(default = true)]
    latching: In<bool>,
    /// Amount that a cycle with the error adds to the count.
    #[hal(default = 1)]
    harm: In<i32>,
    /// Amount that a cycle without the error subtracts from the count.
    #[hal(default = 1)]
    heal: In<i32>,
    /// Count at which the error is reported.
    #[hal(default = 100)]
    threshold: In<i32>,
    /// Maximum count.
    #[hal(default = 1000)]
    max_: In<i32>,
    /// Minimum count; it wins over `max` if the two are crossed.
    min_: In<i32>,
    /// Present count.
    count: Out<i32>,
    /// True while there is an error.
    error_out: Out<bool>,
    /// The opposite of `error-out`.
    #[hal(default = true)]
    ok_out: Out<bool>,
    #[state]
    reset_was: bool,
}

impl Update for SafetyLatch {
    fn update(&mut self, _: Period) {
        let reset = self.reset.get();
        let rising = reset && !self.reset_was;
        self.reset_was = reset;
        let (min, max) = (self.min_.get(), self.max_.get());
        let mut bad = self.error_out.get();
        if rising || !self.enable.get() {
            self.count.set(min);
            bad = false;
        } else {
            let count = self.count.get();
            let moved = if self.error_in.get() {
                count.saturating_add(self.harm.get())
            } else {
                count.saturating_sub(self.heal.get())
            };
            let count = moved.min(max).max(min);
            self.count.set(count);
            if count >= self.threshold.get() {
                bad = true;
            } else if !self.latching.get() && count <= min {
                bad = false;
            }
        }
        self.error_out.set(bad);
        self.ok_out.set(!bad);
    }
}

#[cfg(test)]
mod tests {
    use super::SafetyLatch;
    use hal_bench::trace::replay;

    const PINS: &str = "run safety-latch.0
        in safety-latch.0.error-in safety-latch.0.reset safety-latch.0.enable
        out safety-latch.0.count safety-latch.0.error-out safety-latch.0.ok-out\n";

    #[test]
    fn harm_adds_and_heal_takes_off() {
        let table = format!(
            "load safety_latch
             set safety-latch.0.harm 3
             set safety-latch.0.heal 2
             set safety-latch.0.threshold 6
             set safety-latch.0.max 7
             {PINS}
             1 0 1 | 3 0 1
             0 0 1 | 1 0 1
             0 0 1 | 0 0 1
             1 0 1 | 3 0 1
             1 0 1 | 6 1 0
             1 0 1 | 7 1 0
             0 0 1 | 5 1 0
             0 0 1 | 3 1 0
             0 0 1 | 1 1 0
             0 0 1 | 0 1 0
             0 1 1 | 0 0 1
             1 1 1 | 3 0 1
             1 1 1 | 6 1 0
             1 1 0 | 0 0 1"
        );
        assert_eq!(replay::<SafetyLatch>(&table), 14);
    }

    #[test]
    fn without_the_latch_it_heals() {
        let table = format!(
            "load safety_latch
             set safety-latch.0.latching 0
             set safety-latch.0.threshold 2
             set safety-latch.0.harm 2
             {PINS}
             1 0 1 | 2 1 0
             0 0 1 | 1 1 0
             0 0 1 | 0 0 1"
        );
        assert_eq!(replay::<SafetyLatch>(&table), 3);
    }

    #[test]
    fn the_count_never_wraps_and_min_goes_before_max() {
        let table = format!(
            "load safety_latch
             set safety-latch.0.harm 2147483647
             set safety-latch.0.max 2147483647
             {PINS}
             1 0 1 | 2147483647 1 0
             1 0 1 | 2147483647 1 0
             set safety-latch.0.min 9
             set safety-latch.0.max 5
             0 0 1 | 9 1 0"
        );
        assert_eq!(replay::<SafetyLatch>(&table), 3);
    }
}

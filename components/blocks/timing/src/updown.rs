//! `updown`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Up/down counter for the rising edges of two inputs.
///
/// # Example
///
/// ```hal
/// loadrt updown
/// loadrt threads name1=servo period1=1000000
/// addf updown.0 servo
/// start
/// run 1ms
/// setp updown.0.countup 1
/// run 1ms
/// setp updown.0.countup 0
/// run 1ms
/// setp updown.0.countup 1
/// run 1ms
/// getp updown.0.count # -> 2
/// setp updown.0.countdown 1
/// run 1ms
/// getp updown.0.count # -> 1
/// ```
#[derive(Component)]
pub(crate) struct Updown {
    /// Rising edge counts up.
    countup: In<bool>,
    /// Rising edge counts down.
    countdown: In<bool>,
    /// While true, the count is zero.
    reset: In<bool>,
    /// Present count.
    count: Out<i32>,
    /// TRUE stops the count at `min` and `max`.
    clamp: ParamRw<bool>,
    /// TRUE wraps the count from `max` to `min`, and back; overrides `clamp`.
    wrap: ParamRw<bool>,
    /// Maximum count, if `clamp` or `wrap` is true.
    #[hal(default = i32::MAX)]
    max_: ParamRw<i32>,
    /// Minimum count, if `clamp` or `wrap` is true.
    min_: ParamRw<i32>,
    #[state]
    ran: bool,
    #[state]
    up_was: bool,
    #[state]
    down_was: bool,
}

impl Update for Updown {
    fn update(&mut self, _: Period) {
        let (up, down) = (self.countup.get(), self.countdown.get());
        // An input that is true in the first cycle does not count as risen.
        let (rises, falls) = (self.ran && up && !self.up_was, self.ran && down && !self.down_was);
        (self.ran, self.up_was, self.down_was) = (true, up, down);
        let moved = self.count.get().wrapping_add(i32::from(rises)).wrapping_sub(i32::from(falls));
        let count = if self.reset.get() { 0 } else { moved };
        self.count.set(self.bound(count));
    }
}

impl Updown {
    fn bound(&self, count: i32) -> i32 {
        let (min, max) = (self.min_.get(), self.max_.get());
        let (above, below) = match (self.wrap.get(), self.clamp.get()) {
            (true, _) => (min, max),
            (false, true) => (max, min),
            (false, false) => return count,
        };
        if count > max {
            above
        } else if count < min {
            below
        } else {
            count
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Updown;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Updown>(include_str!("../traces/updown.txt")), 420);
    }

    #[test]
    fn what_is_true_as_it_begins_has_not_risen() {
        let mut bench = Bench::new();
        bench.load::<Updown>(&[]).unwrap();
        bench.set("updown.0.countup", true);
        bench.run("updown.0", 1_000_000);
        assert_eq!(bench.get::<i32>("updown.0.count"), 0);
    }

    #[test]
    fn without_bounds_the_count_wraps_at_32_bits() {
        let mut bench = Bench::new();
        bench.load::<Updown>(&[]).unwrap();
        bench.set("updown.0.count", i32::MAX);
        bench.run("updown.0", 1_000_000);
        bench.set("updown.0.countup", true);
        bench.run("updown.0", 1_000_000);
        assert_eq!(bench.get::<i32>("updown.0.count"), i32::MIN);
    }
}

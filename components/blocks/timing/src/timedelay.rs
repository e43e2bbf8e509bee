//! `timedelay`.
use hal_component::{Component, In, Out, Period, Update};

/// Delay of a bit, with separate times for rising and falling.
///
/// A change that does not last as long as the delay is ignored.
///
/// # Example
///
/// ```hal
/// loadrt timedelay
/// loadrt threads name1=servo period1=1000000
/// addf timedelay.0 servo
/// start
/// setp timedelay.0.on-delay 0.02
/// setp timedelay.0.in 1
/// run 10ms
/// getp timedelay.0.out # -> FALSE
/// run 15ms
/// getp timedelay.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Timedelay {
    /// Input.
    in_: In<bool>,
    /// Time for which `in` must be true before `out` becomes true, in seconds.
    #[hal(default = 0.5)]
    on_delay: In<f64>,
    /// Time for which `in` must be false before `out` becomes false, in seconds.
    #[hal(default = 0.5)]
    off_delay: In<f64>,
    /// The delayed bit.
    out: Out<bool>,
    /// Time for which `in` has differed from `out`, in seconds; it keeps its last value while they are equal.
    elapsed: Out<f64>,
    #[state]
    timer: f64,
}

impl Update for Timedelay {
    fn update(&mut self, period: Period) {
        let on = self.in_.get();
        if on == self.out.get() {
            self.timer = 0.0;
            return;
        }
        self.timer += period.secs();
        self.elapsed.set(self.timer);
        let delay = if on { &self.on_delay } else { &self.off_delay };
        if self.timer >= delay.get() {
            self.timer = 0.0;
            self.out.set(on);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Timedelay;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Timedelay>(include_str!("../traces/timedelay.txt")), 240);
    }
}

//! `time`.
use hal_component::{Component, In, Out, Period, Update};

/// Stopwatch: hours, minutes and seconds.
///
/// # Example
///
/// ```hal
/// loadrt time
/// loadrt threads name1=servo period1=1000000
/// addf time.0 servo
/// start
/// setp time.0.start 1
/// run 75s
/// getp time.0.minutes # -> 1
/// getp time.0.seconds # -> 15
/// ```
#[derive(Component)]
pub(crate) struct Time {
    /// Rising edge starts from zero; the stopwatch runs while this is true.
    start: In<bool>,
    /// While true, holds the stopwatch, whatever `start` is.
    pause: In<bool>,
    /// Seconds, 0 to 59.
    seconds: Out<u32>,
    /// Minutes, 0 to 59.
    minutes: Out<u32>,
    /// Full hours since the start.
    hours: Out<u32>,
    #[state]
    was_started: bool,
    /// Whole seconds.
    #[state]
    whole: u32,
    /// Fraction of the next second.
    #[state]
    part: f64,
}

impl Update for Time {
    fn update(&mut self, period: Period) {
        if !self.pause.get() {
            let start = self.start.get();
            if start && !self.was_started {
                (self.whole, self.part) = (0, 0.0);
            }
            if start {
                self.part += period.secs();
                if self.part >= 1.0 {
                    self.part -= 1.0;
                    self.whole = self.whole.wrapping_add(1);
                }
            }
            self.was_started = start;
        }
        self.seconds.set(self.whole % 60);
        self.minutes.set(self.whole / 60 % 60);
        self.hours.set(self.whole / 3600);
    }
}

#[cfg(test)]
mod tests {
    use super::Time;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Time>(include_str!("../traces/time.txt")), 230);
    }
}

//! `oneshot`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Pulse of a given length at an edge of the input.
///
/// # Example
///
/// ```hal
/// loadrt oneshot
/// loadrt threads name1=servo period1=1000000
/// addf oneshot.0 servo
/// start
/// setp oneshot.0.width 0.01
/// setp oneshot.0.in 1
/// run 5ms
/// getp oneshot.0.out # -> TRUE
/// run 10ms
/// getp oneshot.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Oneshot {
    /// Input.
    in_: In<bool>,
    /// While true, there is no pulse and `in` counts as false, so that an input that is true after the reset triggers a
    /// pulse.
    reset: In<bool>,
    /// Length of the pulse, in seconds; 0 or less: no pulse.
    width: In<f64>,
    /// Pulse output.
    out: Out<bool>,
    /// The opposite of `out`.
    out_not: Out<bool>,
    /// Remaining time of the pulse, in seconds; it keeps its value during a reset.
    time_left: Out<f64>,
    /// TRUE: an edge during a pulse restarts the pulse.
    #[hal(default = true)]
    retriggerable: ParamRw<bool>,
    /// TRUE: the rising edge triggers.
    #[hal(default = true)]
    rising: ParamRw<bool>,
    /// TRUE: the falling edge triggers.
    falling: ParamRw<bool>,
    #[state]
    was: bool,
    #[state]
    left: f64,
}

impl Update for Oneshot {
    fn update(&mut self, period: Period) {
        if self.reset.get() {
            self.was = false;
            self.left = 0.0;
        } else {
            self.count_down(period.secs());
            self.time_left.set(self.left);
        }
        let out = self.left > 0.0;
        self.out.set(out);
        self.out_not.set(!out);
    }
}

impl Oneshot {
    fn count_down(&mut self, dt: f64) {
        let now = self.in_.get();
        let rising = now && !self.was && self.rising.get();
        let falling = !now && self.was && self.falling.get();
        self.was = now;
        let free = self.left <= 0.0 || self.retriggerable.get();
        if self.left > 0.0 {
            self.left -= dt;
            if self.left < 0.0 {
                self.left = 0.0;
            }
        }
        if (rising || falling) && free {
            self.left = self.width.get();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Oneshot;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Oneshot>(include_str!("../traces/oneshot.txt")), 660);
    }
}

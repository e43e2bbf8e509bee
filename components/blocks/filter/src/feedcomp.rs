//! `feedcomp`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Scales a number with the speed, such as the power of a laser.
///
/// # Example
///
/// ```hal
/// # At half of the feed rate the laser gets half of its power.
/// loadrt feedcomp
/// loadrt threads name1=servo period1=1000000
/// addf feedcomp.0 servo
/// start
/// setp feedcomp.0.feed 200
/// setp feedcomp.0.in 8
/// setp feedcomp.0.vel 100
/// run 1ms
/// getp feedcomp.0.out # -> 8
/// setp feedcomp.0.enable 1
/// run 1ms
/// getp feedcomp.0.out # -> 4
/// ```
#[derive(Component)]
pub(crate) struct Feedcomp {
    /// `in` times `vel` / `feed`, in the unit of `in`, if enabled; a feed of 0 makes it infinite or NaN.
    out: Out<f64>,
    /// Input at the feed rate, in any unit.
    in_: In<f64>,
    /// TRUE scales with the speed; FALSE passes `in` unchanged.
    enable: In<bool>,
    /// Present speed, in units per second.
    vel: In<f64>,
    /// Feed rate, in units per second.
    feed: ParamRw<f64>,
}

impl Update for Feedcomp {
    fn update(&mut self, _: Period) {
        let x = self.in_.get();
        self.out.set(if self.enable.get() { x * (self.vel.get() / self.feed.get()) } else { x });
    }
}

#[cfg(test)]
mod tests {
    use super::Feedcomp;
    use hal_bench::trace::replay;

    #[test]
    fn in_proportion_if_enabled() {
        let rows = replay::<Feedcomp>(
            "load feedcomp
             set feedcomp.0.feed 4
             run feedcomp.0
             in feedcomp.0.in feedcomp.0.vel feedcomp.0.enable
             out feedcomp.0.out
             3 1 0 | 3
             3 1 1 | 0.75
             3 -8 1 | -6
             set feedcomp.0.feed 0
             3 1 1 | inf
             3 0 1 | nan
             3 0 0 | 3",
        );
        assert_eq!(rows, 6);
    }
}

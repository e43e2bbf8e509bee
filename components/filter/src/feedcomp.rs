//! `feedcomp`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// A number in proportion to speed, such as the power of a laser.
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
    /// The number times `vel` over `feed`, in its unit, if enabled; a feed of 0 makes it infinite,
    /// or no number.
    out: Out<f64>,
    /// The number at the feed rate, in any unit.
    in_: In<f64>,
    /// Whether speed counts; otherwise `out` is `in`.
    enable: In<bool>,
    /// The speed, in units per second.
    vel: In<f64>,
    /// The feed rate, in units per second.
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
    use hal_component::trace::replay;

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

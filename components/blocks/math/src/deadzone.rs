//! `deadzone`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Dead zone around a centre.
///
/// # Example
///
/// ```hal
/// loadrt deadzone
/// loadrt threads name1=servo period1=1000000
/// addf deadzone.0 servo
/// start
/// setp deadzone.0.threshold 2
/// setp deadzone.0.in 0.9
/// run 1ms
/// getp deadzone.0.out # -> 0
/// setp deadzone.0.in 5
/// run 1ms
/// getp deadzone.0.out # -> 4
/// ```
#[derive(Component)]
pub(crate) struct Deadzone {
    /// The number, in any unit.
    in_: In<f64>,
    /// `center` within the zone; beyond it, the number less half of the zone's width; in the number's unit.
    out: Out<f64>,
    /// Centre of the zone, in the number's unit.
    center: ParamRw<f64>,
    /// Width of the zone, in the number's unit.
    #[hal(default = 1.0)]
    threshold: ParamRw<f64>,
}

impl Update for Deadzone {
    fn update(&mut self, _: Period) {
        let (x, center, half) = (self.in_.get(), self.center.get(), self.threshold.get() / 2.0);
        self.out.set(if x < center - half {
            x + half
        } else if x > center + half {
            x - half
        } else {
            center
        });
    }
}

#[cfg(test)]
mod tests {
    use super::Deadzone;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Deadzone>(include_str!("../traces/deadzone.txt")), 85);
    }
}

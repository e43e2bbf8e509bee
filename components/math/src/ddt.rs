//! `ddt`.
use hal_component::{Component, In, Out, Period, Update};

/// Rate of change of a number.
///
/// # Example
///
/// ```hal
/// loadrt ddt
/// loadrt threads name1=servo period1=1000000
/// addf ddt.0 servo
/// start
/// setp ddt.0.in 1
/// run 1ms
/// setp ddt.0.in 3
/// run 1ms
/// getp ddt.0.out # -> 2000
/// ```
#[derive(Component)]
pub(crate) struct Ddt {
    /// The number, in units.
    in_: In<f64>,
    /// Its change since the last run, in units per second; before the first run it counts as 0.
    out: Out<f64>,
    #[state]
    old: f64,
}

impl Update for Ddt {
    fn update(&mut self, period: Period) {
        let x = self.in_.get();
        self.out.set((x - self.old) / period.secs());
        self.old = x;
    }
}

#[cfg(test)]
mod tests {
    use super::Ddt;
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Ddt>(include_str!("../traces/ddt.txt")), 100);
    }
}

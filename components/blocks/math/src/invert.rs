//! `invert`.
use crate::bounds::away;
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Reciprocal of a number.
///
/// # Example
///
/// ```hal
/// loadrt invert
/// loadrt threads name1=servo period1=1000000
/// addf invert.0 servo
/// start
/// setp invert.0.in 4
/// run 1ms
/// getp invert.0.out # -> 0.25
/// ```
#[derive(Component)]
pub(crate) struct Invert {
    /// The number, in any unit.
    in_: In<f64>,
    /// 1 / `in`, per unit of it; `deadband` keeps the number away from zero.
    out: Out<f64>,
    /// Minimum magnitude of the number, in its unit; a smaller number is replaced by this with its sign (zero counts as
    /// positive). A value below 1e-12 is set to 1e-12.
    deadband: ParamRw<f64>,
}

impl Update for Invert {
    fn update(&mut self, _: Period) {
        self.out.set(1.0 / away(self.in_.get(), &self.deadband));
    }
}

#[cfg(test)]
mod tests {
    use super::Invert;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Invert>(include_str!("../traces/invert.txt")), 42);
    }
}

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
    /// 1 / `in`, per unit of it; the number is kept away from zero by `deadband`.
    out: Out<f64>,
    /// A number closer to zero than this, in its unit, is taken as this, with its sign (zero as
    /// positive); positive, and set to 1e-12 when it is less.
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
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Invert>(include_str!("../traces/invert.txt")), 42);
    }
}

//! `blend`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Mixture of two numbers.
///
/// # Example
///
/// ```hal
/// loadrt blend
/// loadrt threads name1=servo period1=1000000
/// addf blend.0 servo
/// start
/// setp blend.0.in1 10
/// setp blend.0.in2 20
/// setp blend.0.select 0.25
/// run 1ms
/// getp blend.0.out # -> 17.5
/// ```
#[derive(Component)]
pub(crate) struct Blend {
    /// Number at `select` 1, in any unit.
    in1: In<f64>,
    /// Number at `select` 0, in the same unit.
    in2: In<f64>,
    /// Share of `in1`, 0 to 1.
    select: In<f64>,
    /// Mixture, in the unit of the inputs.
    out: Out<f64>,
    /// TRUE: `select` may go beyond 0 and 1, which extrapolates; FALSE: it is limited.
    open: ParamRw<bool>,
}

impl Update for Blend {
    fn update(&mut self, _: Period) {
        let select = self.select.get();
        let share = if self.open.get() { select } else { below(above(select)) };
        self.out.set(self.in1.get() * share + self.in2.get() * (1.0 - share));
    }
}

fn above(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}

fn below(x: f64) -> f64 {
    if x > 1.0 { 1.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::Blend;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Blend>(include_str!("../traces/blend.txt")), 80);
    }
}

//! `maj3`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Majority of three bits.
///
/// # Example
///
/// ```hal
/// loadrt maj3
/// loadrt threads name1=servo period1=1000000
/// addf maj3.0 servo
/// start
/// setp maj3.0.in1 1
/// run 1ms
/// getp maj3.0.out # -> FALSE
/// setp maj3.0.in3 1
/// run 1ms
/// getp maj3.0.out # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Maj3 {
    /// First input.
    in1: In<bool>,
    /// Second input.
    in2: In<bool>,
    /// Third input.
    in3: In<bool>,
    /// True when two or three inputs are true; the opposite with `invert`.
    out: Out<bool>,
    /// TRUE inverts the output.
    invert: ParamRw<bool>,
}

impl Update for Maj3 {
    fn update(&mut self, _: Period) {
        let inputs = [&self.in1, &self.in2, &self.in3];
        let most = inputs.iter().filter(|input| input.get()).count() >= 2;
        self.out.set(most != self.invert.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Maj3;
    use hal_bench::trace::replay;

    #[test]
    fn truth_table_as_recorded() {
        assert_eq!(replay::<Maj3>(include_str!("../traces/maj3.txt")), 16);
    }
}

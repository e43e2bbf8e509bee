//! `knob2float`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Value that a knob with an encoder turns up and down.
///
/// # Example
///
/// ```hal
/// loadrt knob2float
/// loadrt threads name1=servo period1=1000000
/// addf knob2float.0 servo
/// setp knob2float.0.scale 0.01
/// setp knob2float.0.enable 1
/// start
/// run 1ms
/// setp knob2float.0.counts 25
/// run 1ms
/// getp knob2float.0.out # -> 0.25
/// ```
#[derive(Component)]
pub(crate) struct Knob2float {
    /// Count of the encoder; where it wraps around, the value jumps to one of its limits.
    counts: In<i32>,
    /// TRUE lets the knob change the value; FALSE holds it.
    enable: In<bool>,
    /// Change of the value per count, in its unit.
    scale: In<f64>,
    /// Value, in any unit.
    out: Out<f64>,
    /// Maximum of the value, in the same unit.
    #[hal(default = 1.0)]
    max_out: ParamRw<f64>,
    /// Minimum of the value, in the same unit; if it is above `max-out`, it is set to `max-out`.
    min_out: ParamRw<f64>,
    #[state]
    last: i32,
}

impl Update for Knob2float {
    fn update(&mut self, _: Period) {
        let counts = self.counts.get();
        let steps = f64::from(counts) - f64::from(self.last);
        self.last = counts;
        if self.max_out.get() < self.min_out.get() {
            self.min_out.set(self.max_out.get());
        }
        if self.enable.get() {
            let mut out = self.out.get() + steps * self.scale.get();
            if out < self.min_out.get() {
                out = self.min_out.get();
            }
            if out > self.max_out.get() {
                out = self.max_out.get();
            }
            self.out.set(out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Knob2float;
    use hal_bench::trace::replay;

    #[test]
    fn turns_within_limits() {
        let rows = "load knob2float
            set knob2float.0.scale 0.125
            run knob2float.0
            in knob2float.0.counts knob2float.0.enable
            out knob2float.0.out
            8 0 | 0
            . 1 | 0
            10 1 | 0.25
            100 1 | 1
            99 1 | 0.875
            -100 1 | 0
            -90 0 | 0
            -89 1 | 0.125
            set knob2float.0.min-out 0.5
            . . | 0.5
            set knob2float.0.max-out 0.25
            . . | 0.25
            expect knob2float.0.min-out 0.25";
        assert_eq!(replay::<Knob2float>(rows), 10);
    }
}

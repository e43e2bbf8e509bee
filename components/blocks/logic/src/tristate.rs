//! `tristate_bit` and `tristate_float`.
use hal_component::{Component, In, Io, Period, Update};

/// Bit that is written only while enabled.
///
/// Several of these may share a signal if at most one is enabled at a time; while none is enabled, the signal keeps its
/// value, and others may write it.
///
/// # Example
///
/// ```hal
/// # Two buttons share a lamp; a selector says whose it is.
/// loadrt tristate_bit count=2
/// loadrt not
/// loadrt threads name1=servo period1=1000000
/// addf not.0 servo
/// addf tristate-bit.0 servo
/// addf tristate-bit.1 servo
/// net first not.0.in tristate-bit.0.enable
/// net second not.0.out tristate-bit.1.enable
/// net lamp tristate-bit.0.out tristate-bit.1.out
/// start
/// setp tristate-bit.1.in 1
/// run 1ms
/// gets lamp # -> TRUE
/// sets first 1
/// run 1ms
/// gets lamp # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct TristateBit {
    /// Input bit.
    in_: In<bool>,
    /// Output that `in` is written to; while `enable` is false, nothing is written.
    out: Io<bool>,
    /// While true, `in` is written to `out` in each cycle.
    enable: In<bool>,
}

impl Update for TristateBit {
    fn update(&mut self, _: Period) {
        if self.enable.get() {
            self.out.set(self.in_.get());
        }
    }
}

/// Number that is written only while enabled.
///
/// Several of these may share a signal if at most one is enabled at a time; while none is enabled, the signal keeps its
/// value, and others may write it.
///
/// # Example
///
/// ```hal
/// loadrt tristate_float
/// loadrt threads name1=servo period1=1000000
/// addf tristate-float.0 servo
/// start
/// setp tristate-float.0.in 2.5
/// run 1ms
/// getp tristate-float.0.out # -> 0
/// setp tristate-float.0.enable 1
/// run 1ms
/// getp tristate-float.0.out # -> 2.5
/// ```
#[derive(Component)]
pub(crate) struct TristateFloat {
    /// Input number, in any unit.
    in_: In<f64>,
    /// Output that `in` is written to, in its unit; while `enable` is false, nothing is written.
    out: Io<f64>,
    /// While true, `in` is written to `out` in each cycle.
    enable: In<bool>,
}

impl Update for TristateFloat {
    fn update(&mut self, _: Period) {
        if self.enable.get() {
            self.out.set(self.in_.get());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{TristateBit, TristateFloat};
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn nothing_is_written_while_not_enabled() {
        let rows = replay::<TristateBit>(
            "load tristate_bit
             run tristate-bit.0
             in tristate-bit.0.in tristate-bit.0.enable
             out tristate-bit.0.out
             1 0 | 0
             1 1 | 1
             0 0 | 1
             0 1 | 0",
        );
        assert_eq!(rows, 4);
        let rows = replay::<TristateFloat>(
            "load tristate_float
             run tristate-float.0
             in tristate-float.0.in tristate-float.0.enable
             out tristate-float.0.out
             1.5 0 | 0
             1.5 1 | 1.5
             nan 0 | 1.5
             nan 1 | nan
             -inf 1 | -inf",
        );
        assert_eq!(rows, 5);
    }

    #[test]
    fn what_others_write_stays() {
        let mut bench = Bench::new();
        bench.load::<TristateFloat>(&[]).unwrap();
        bench.set("tristate-float.0.out", 7.0);
        bench.run("tristate-float.0", 1_000_000);
        assert_eq!(bench.get::<f64>("tristate-float.0.out"), 7.0);
    }
}

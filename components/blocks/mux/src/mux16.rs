//! `mux16`.
use hal_component::{Component, In, Out, ParamRo, Period, Update, to_s32};

/// Multiplexer for sixteen numbers.
///
/// The selectors form the index of the input, `sel0` + 2·`sel1` + 4·`sel2` + 8·`sel3`, or its Gray code.
///
/// # Example
///
/// ```hal
/// loadrt mux16
/// loadrt threads name1=servo period1=1000000
/// addf mux16.0 servo
/// start
/// setp mux16.0.in09 7.9
/// setp mux16.0.sel0 1
/// setp mux16.0.sel3 1
/// run 1ms
/// getp mux16.0.out-f # -> 7.9
/// getp mux16.0.out-s # -> 7
/// ```
#[derive(Component)]
pub(crate) struct Mux16 {
    /// TRUE: the selectors are in Gray code, in which neighbouring positions differ by one bit.
    use_graycode: In<bool>,
    /// TRUE: nothing changes while no selector is true.
    suppress_no_input: In<bool>,
    /// Time for which a new selection must last before it counts, in seconds.
    debounce_time: In<f64>,
    /// Selector bit with the value 1, 2, 4 or 8.
    #[hal(name = "sel#", count = 4_u32)]
    sel: Vec<In<bool>>,
    /// Input number, in any unit.
    #[hal(name = "in##", count = 16_u32)]
    in_: Vec<In<f64>>,
    /// Selected number, in its unit.
    out_f: Out<f64>,
    /// Selected number without its fraction; -2147483648 if it does not fit in 32 bits.
    out_s: Out<i32>,
    /// Time for which the selectors have differed from the active input, in seconds.
    elapsed: ParamRo<f64>,
    /// Index that the selectors give; its input becomes active after `debounce-time`.
    selected: ParamRo<i32>,
    /// Index of the active input.
    #[state]
    passed: u8,
    /// True during the debounce time of a new selection.
    #[state]
    waits: bool,
}

impl Mux16 {
    /// Returns the index that the selectors give, without Gray code conversion.
    fn wanted(&self) -> u8 {
        let bits = self.sel.iter().enumerate();
        bits.fold(0, |n, (i, bit)| n | u8::from(bit.get()) << i)
    }
}

impl Update for Mux16 {
    fn update(&mut self, period: Period) {
        let bits = self.wanted();
        if self.suppress_no_input.get() && bits == 0 {
            return;
        }
        let number = if self.use_graycode.get() { from_gray(bits) } else { bits };
        self.selected.set(i32::from(number));
        if number != self.passed {
            // The debounce time is not reset if the selection returns meanwhile.
            if !self.waits {
                self.elapsed.set(0.0);
            }
            self.waits = self.elapsed.get() < self.debounce_time.get();
            if self.waits {
                self.elapsed.set(self.elapsed.get() + period.secs());
                return;
            }
            self.passed = number;
        }
        let chosen = usize::try_from(self.selected.get()).ok().and_then(|n| self.in_.get(n));
        let value = chosen.map_or(0.0, In::get);
        self.out_f.set(value);
        self.out_s.set(to_s32(value));
    }
}

fn from_gray(bits: u8) -> u8 {
    let bits = bits ^ bits >> 2;
    bits ^ bits >> 1
}

#[cfg(test)]
mod tests {
    use super::Mux16;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Mux16>(include_str!("../traces/mux16.txt")), 232);
    }
}

//! `mux16`.
use hal_component::{Component, In, Out, ParamRo, Period, Update, to_s32};

/// One of sixteen numbers.
///
/// The selectors form its number, `sel0` + 2·`sel1` + 4·`sel2` + 8·`sel3`, or its Gray code.
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
    /// Whether the selectors are in Gray code, in which neighbours differ by one switch.
    use_graycode: In<bool>,
    /// Whether nothing changes while no selector is true.
    suppress_no_input: In<bool>,
    /// For how long the selectors must say something else before it counts, in seconds.
    debounce_time: In<f64>,
    /// A selector, worth 1, 2, 4 and 8.
    #[hal(name = "sel#", count = 4_u32)]
    sel: Vec<In<bool>>,
    /// A number to choose, in any unit.
    #[hal(name = "in##", count = 16_u32)]
    in_: Vec<In<f64>>,
    /// The chosen number, in its unit.
    out_f: Out<f64>,
    /// The chosen number without its fraction; one that does not fit in 32 bits becomes the lowest.
    out_s: Out<i32>,
    /// For how long the selectors have said something else than what goes through, in seconds.
    elapsed: ParamRo<f64>,
    /// The number that the selectors say; it goes through after `debounce-time`.
    selected: ParamRo<i32>,
    /// The number of the input that goes through.
    #[state]
    passed: u8,
    /// Whether another one is waited for.
    #[state]
    waits: bool,
}

impl Mux16 {
    /// What the selectors say.
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
            // What is waited for counts on, should it come back.
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
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Mux16>(include_str!("../traces/mux16.txt")), 232);
    }
}

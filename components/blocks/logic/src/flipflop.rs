//! `flipflop`.
use hal_component::{Component, In, Io, Period, Update};

/// D flip-flop with set and reset.
///
/// `reset` overrides `set`, and `set` overrides the clock.
///
/// # Example
///
/// ```hal
/// loadrt flipflop
/// loadrt threads name1=servo period1=1000000
/// addf flipflop.0 servo
/// start
/// setp flipflop.0.data 1
/// run 1ms
/// getp flipflop.0.out # -> FALSE
/// setp flipflop.0.clk 1
/// run 1ms
/// getp flipflop.0.out # -> TRUE
/// setp flipflop.0.reset 1
/// run 1ms
/// getp flipflop.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Flipflop {
    /// Value that a rising edge of `clk` stores.
    data: In<bool>,
    /// Clock; its rising edge stores `data`. An edge while `set` or `reset` is true is ignored.
    clk: In<bool>,
    /// While true, the output is true, unless `reset` is true.
    set: In<bool>,
    /// While true, the output is false.
    reset: In<bool>,
    /// Stored value; a value written by others is kept until the next change.
    out: Io<bool>,
    /// The opposite of `out`.
    out_not: Io<bool>,
    #[state]
    clk_was: bool,
}

impl Update for Flipflop {
    fn update(&mut self, _: Period) {
        let clk = self.clk.get();
        let rising = clk && !self.clk_was;
        self.clk_was = clk;
        let value = if self.reset.get() {
            false
        } else if self.set.get() {
            true
        } else if rising {
            self.data.get()
        } else {
            self.out.get()
        };
        self.out.set(value);
        self.out_not.set(!value);
    }
}

#[cfg(test)]
mod tests {
    use super::Flipflop;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Flipflop>(include_str!("../traces/flipflop.txt")), 90);
    }
}

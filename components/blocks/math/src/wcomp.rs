//! `wcomp`.
use hal_component::{Component, In, Out, Period, Update};

/// Window comparator.
///
/// # Example
///
/// ```hal
/// loadrt wcomp
/// loadrt threads name1=servo period1=1000000
/// addf wcomp.0 servo
/// start
/// setp wcomp.0.min 1
/// setp wcomp.0.max 3
/// setp wcomp.0.in 2
/// run 1ms
/// getp wcomp.0.out # -> TRUE
/// setp wcomp.0.in 4
/// run 1ms
/// getp wcomp.0.out # -> FALSE
/// getp wcomp.0.over # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Wcomp {
    /// The number, in any unit.
    in_: In<f64>,
    /// Lower edge of the window, in the number's unit.
    min_: In<f64>,
    /// Upper edge of the window, in the same unit.
    max_: In<f64>,
    /// True when the number is strictly between the edges.
    out: Out<bool>,
    /// True when the number is at or below the lower edge.
    under: Out<bool>,
    /// True when the number is at or above the upper edge.
    over: Out<bool>,
}

impl Update for Wcomp {
    fn update(&mut self, _: Period) {
        let x = self.in_.get();
        let (under, over) = (x <= self.min_.get(), x >= self.max_.get());
        self.under.set(under);
        self.over.set(over);
        self.out.set(!under && !over);
    }
}

#[cfg(test)]
mod tests {
    use super::Wcomp;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Wcomp>(include_str!("../traces/wcomp.txt")), 50);
    }
}

//! `select8`.
use hal_component::{Component, In, Out, Period, Update};

/// Decoder of a number to one of eight bits.
///
/// # Example
///
/// ```hal
/// loadrt select8
/// loadrt threads name1=servo period1=1000000
/// addf select8.0 servo
/// start
/// setp select8.0.sel 3
/// run 1ms
/// getp select8.0.out3 # -> TRUE
/// getp select8.0.out0 # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Select8 {
    /// Index of the output that is true; with an index outside 0 to 7, no output is true.
    sel: In<i32>,
    /// Enables the outputs; while FALSE, all outputs are false.
    #[hal(default = true)]
    enable: In<bool>,
    /// Output, true when its index is selected.
    #[hal(name = "out#", count = 8_u32)]
    out: Vec<Out<bool>>,
}

impl Update for Select8 {
    fn update(&mut self, _: Period) {
        let chosen = usize::try_from(self.sel.get()).ok().filter(|_| self.enable.get());
        for (i, out) in self.out.iter().enumerate() {
            out.set(chosen == Some(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Select8;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Select8>(include_str!("../traces/select8.txt")), 16);
    }
}

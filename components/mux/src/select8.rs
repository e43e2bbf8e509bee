//! `select8`.
use hal_component::{Component, In, Out, Period, Update};

/// One of eight bits, by number.
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
    /// The number of the output that is true; none for numbers beyond 0 to 7.
    sel: In<i32>,
    /// Whether there is one.
    #[hal(default = true)]
    enable: In<bool>,
    /// An output, true when its number is chosen.
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
    use hal_component::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Select8>(include_str!("../traces/select8.txt")), 16);
    }
}

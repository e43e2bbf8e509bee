//! `toggle`.
use hal_component::{Component, In, Io, ParamRw, Period, Update};

/// Push-on, push-off button.
///
/// The input is debounced by counting: each cycle with the button down counts up to `debounce`, each cycle with it up
/// counts down to zero. The output changes when the count reaches `debounce`, and changes again only after the count
/// was at zero.
///
/// # Example
///
/// ```hal
/// loadrt toggle
/// loadrt threads name1=servo period1=1000000
/// addf toggle.0 servo
/// start
/// setp toggle.0.in 1
/// run 5ms
/// getp toggle.0.out # -> TRUE
/// setp toggle.0.in 0
/// run 5ms
/// getp toggle.0.out # -> TRUE
/// setp toggle.0.in 1
/// run 5ms
/// getp toggle.0.out # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Toggle {
    /// Button input.
    in_: In<bool>,
    /// Output that changes each time the button is pressed; others may write it.
    out: Io<bool>,
    /// Number of cycles for which the button must be down, or up, to count as such; 0, or more than 10000, is set to 2.
    #[hal(default = 2)]
    debounce: ParamRw<u32>,
    #[state]
    count: u32,
    #[state]
    pressed: bool,
}

impl Update for Toggle {
    fn update(&mut self, _: Period) {
        if !(1..=10_000).contains(&self.debounce.get()) {
            self.debounce.set(2);
        }
        let top = self.debounce.get();
        if !self.in_.get() {
            self.count = self.count.saturating_sub(1);
            self.pressed &= self.count != 0;
            return;
        }
        self.count = self.count.saturating_add(1).min(top);
        if self.count >= top && !self.pressed {
            self.pressed = true;
            self.out.set(!self.out.get());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Toggle;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Toggle>(include_str!("../traces/toggle.txt")), 320);
    }

    #[test]
    fn others_may_write_the_output() {
        let mut bench = Bench::new();
        bench.load::<Toggle>(&[]).unwrap();
        bench.set("toggle.0.out", true);
        bench.set("toggle.0.in", true);
        for wanted in [true, false, false] {
            bench.run("toggle.0", 1_000_000);
            assert_eq!(bench.get::<bool>("toggle.0.out"), wanted);
        }
    }
}

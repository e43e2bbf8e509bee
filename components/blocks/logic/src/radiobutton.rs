//! `radiobutton`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of buttons.
const MAX: i64 = 32;
/// Default number of buttons.
const DEFAULT: i64 = 4;

/// Group of buttons of which one is selected.
#[derive(Touch)]
pub(crate) struct Radiobutton {
    buttons: Vec<Button>,
    selected: Out<i32>,
    value: Out<f64>,
}

/// Button of the group.
#[derive(Touch)]
struct Button {
    sel: In<bool>,
    input: In<f64>,
    out: Out<bool>,
    #[state]
    was: bool,
}

impl Component for Radiobutton {
    const NAME: &'static str = "radiobutton";
    const DOC: &'static str = "Radio buttons: pressing one releases the others.\n\n\
        Each button has a number that goes to `value` while the button is down, such as the size \
        of a step of a hand wheel. The first button is down from the start.\n\n\
        `personality=` is the number of buttons, 1 to 32; 4 without it.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt radiobutton personality=3\n\
        loadrt threads name1=servo period1=1000000\n\
        addf radiobutton.0 servo\n\
        start\n\
        setp radiobutton.0.input-00 0.001\n\
        setp radiobutton.0.input-01 0.01\n\
        setp radiobutton.0.input-02 0.1\n\
        setp radiobutton.0.sel-02 1\n\
        run 1ms\n\
        setp radiobutton.0.sel-02 0\n\
        run 1ms\n\
        getp radiobutton.0.out-02 # -> TRUE\n\
        getp radiobutton.0.selected # -> 2\n\
        getp radiobutton.0.value # -> 0.1\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin sel-##", DEFAULT, MAX)?;
        let mut buttons = Vec::new();
        for i in 0..n {
            let sel = "A rising edge presses this button; of several at once, the last counts.";
            let sel = b.item(&format!("sel-{i:02}"), sel, false)?;
            let input = "The number that goes to `value` while this button is down, in any unit.";
            let input = b.item(&format!("input-{i:02}"), input, 0.0)?;
            let out = b.item(&format!("out-{i:02}"), "True while this button is down.", false)?;
            buttons.push(Button { sel, input, out, was: false });
        }
        let selected = b.item("selected", "The number of the button that is down, from 0.", 0)?;
        let value = b.item("value", "The number of the button that is down, in its unit.", 0.0)?;
        b.function("", "Determines which button is down.", Self { buttons, selected, value })
    }
}

impl Update for Radiobutton {
    fn update(&mut self, _: Period) {
        let mut chosen = self.selected.get();
        for (i, b) in (0..).zip(&mut self.buttons) {
            let now = b.sel.get();
            if now && !b.was {
                chosen = i;
            }
            b.was = now;
        }
        self.selected.set(chosen);
        for (i, b) in (0..).zip(&self.buttons) {
            b.out.set(i == chosen);
            if i == chosen {
                self.value.set(b.input.get());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Radiobutton;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn one_is_down() {
        let rows = replay::<Radiobutton>(
            "load radiobutton personality=3
             set radiobutton.0.input-00 0.5
             set radiobutton.0.input-01 1.5
             set radiobutton.0.input-02 2.5
             run radiobutton.0
             in radiobutton.0.sel-00 radiobutton.0.sel-01 radiobutton.0.sel-02
             out radiobutton.0.out-00 radiobutton.0.out-01 radiobutton.0.out-02 radiobutton.0.selected radiobutton.0.value
             0 0 0 | 1 0 0 0 0.5
             0 1 0 | 0 1 0 1 1.5
             1 1 0 | 1 0 0 0 0.5
             0 0 0 | 1 0 0 0 0.5
             1 0 1 | 0 0 1 2 2.5
             1 1 1 | 0 1 0 1 1.5
             set radiobutton.0.input-01 nan
             0 0 0 | 0 1 0 1 nan",
        );
        assert_eq!(rows, 7);
    }

    #[test]
    fn no_more_than_32() {
        let mut bench = Bench::new();
        bench.load::<Radiobutton>(&["personality=32"]).unwrap();
        assert_eq!(bench.names().len(), 3 * 32 + 2);
        let refused = Bench::new().load::<Radiobutton>(&["personality=33"]).unwrap_err();
        assert!(refused.starts_with(
            "Pin sel-##: Requested size 33 exceeds max size 32: personality= is 1 to "
        ));
    }
}

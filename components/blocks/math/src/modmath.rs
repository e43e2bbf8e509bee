//! `modmath`.
use hal_component::{
    Arg, Builder, Component, Error, In, Io, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Shorter direction of rotation.
pub(crate) struct Modmath;

impl Component for Modmath {
    const NAME: &'static str = "modmath";
    const DOC: &'static str = "Shorter direction to a position on a tool turret or dial: up or \
        down.\n\n\
        `mod_dir=2` makes `mod-dir.0` and `mod-dir.1`. Positions are counted from `min-num` to \
        `max-num`, and `min-num` follows `max-num`; if both directions are equally long, the one \
        that does not cross the ends is selected. Whole turns do not count.\n\n\
        # Example\n\n\
        ```hal\n\
        # A turret with 8 tools, 1 to 8: from 7 to 2 it is shorter over 8.\n\
        loadrt modmath mod_dir=1\n\
        loadrt threads name1=servo period1=1000000\n\
        addf mod-dir.0 servo\n\
        start\n\
        setp mod-dir.0.min-num 1\n\
        setp mod-dir.0.max-num 8\n\
        setp mod-dir.0.actual 7\n\
        setp mod-dir.0.desired 2\n\
        run 1ms\n\
        getp mod-dir.0.up # -> TRUE\n\
        getp mod-dir.0.down # -> FALSE\n\
        getp mod-dir.0.on-target # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::int("mod_dir", "Number of channels.").required().within(1.0, 16.0)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.arg_int("mod_dir").unwrap_or(0);
        for i in 0..n {
            let name = format!("mod-dir.{i}");
            let pin = |pin: &str| format!("{name}.{pin}");
            let actual = b.item(&pin("actual"), "Current position.", 0)?;
            let desired = b.item(&pin("desired"), "Target position.", 0)?;
            let up = b.item(&pin("up"), "True while the position must count up.", false)?;
            let down = b.item(&pin("down"), "True while the position must count down.", false)?;
            let doc = "True while the position is at the target.";
            let on_target = b.item(&pin("on-target"), doc, true)?;
            let min = b.item(&pin("min-num"), "The lowest position.", 0)?;
            let max = b.item(&pin("max-num"), "The highest position.", 15)?;
            let doc = "True if the lowest position follows the highest.";
            let wrap = b.item(&pin("wrap"), doc, true)?;
            let dir = Direction { actual, desired, up, down, on_target, min, max, wrap };
            b.function(&name, "Selects the direction.", dir)?;
        }
        Ok(())
    }
}

#[derive(Touch)]
struct Direction {
    actual: In<i32>,
    desired: In<i32>,
    up: Out<bool>,
    down: Out<bool>,
    on_target: Out<bool>,
    min: Io<i32>,
    max: Io<i32>,
    wrap: Io<bool>,
}

impl Update for Direction {
    fn update(&mut self, _: Period) {
        let min = self.min.get();
        let round = self.max.get().wrapping_sub(min).wrapping_add(1);
        let within =
            |position: In<i32>| position.get().wrapping_sub(min).checked_rem(round).unwrap_or(0);
        let mut far = within(self.desired).wrapping_sub(within(self.actual));
        if self.wrap.get() {
            if far > round / 2 {
                far = far.wrapping_sub(round);
            } else if far < -(round / 2) {
                far = far.wrapping_add(round);
            }
        }
        let (up, moves) = (far > 0, far != 0);
        self.up.set(moves && up);
        self.down.set(moves && !up);
        self.on_target.set(!moves);
    }
}

#[cfg(test)]
mod tests {
    use super::Modmath;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Modmath>(include_str!("../traces/modmath.txt")), 272);
    }

    #[test]
    fn the_shorter_way() {
        let rows = replay::<Modmath>(
            "load modmath mod_dir=1
             run mod-dir.0
             in mod-dir.0.actual mod-dir.0.desired mod-dir.0.wrap
             out mod-dir.0.up mod-dir.0.down mod-dir.0.on-target
             0 0 1 | 0 0 1
             0 8 1 | 1 0 0
             0 9 1 | 0 1 0
             14 2 1 | 1 0 0
             2 14 1 | 0 1 0
             2 14 0 | 1 0 0
             14 2 0 | 0 1 0
             set mod-dir.0.min-num 3
             set mod-dir.0.max-num 10
             10 3 1 | 1 0 0
             3 7 1 | 1 0 0
             7 3 1 | 0 1 0",
        );
        assert_eq!(rows, 10);
    }

    #[test]
    fn one_to_sixteen() {
        for wrong in ["mod_dir=0", "mod_dir=17"] {
            let said = Bench::new().load::<Modmath>(&[wrong]).unwrap_err();
            assert!(said.contains("out of range for parameter `mod_dir="), "{said}");
        }
    }
}

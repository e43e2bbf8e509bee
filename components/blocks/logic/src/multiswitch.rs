//! `multiswitch`.
use hal_component::{
    Arg, Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Maximum number of outputs.
const MAX: i64 = 32;
/// Default number of outputs.
const DEFAULT: i64 = 4;
/// Maximum number of instances.
const INSTANCES: u32 = 16;

/// Row of bits of which one is true.
pub(crate) struct Multiswitch;

impl Component for Multiswitch {
    const NAME: &'static str = "multiswitch";
    const DOC: &'static str = "A switch with several positions, moved by two buttons.\n\n\
        The output of its position is true. The buttons move the switch, and from the last \
        position it continues at the first.\n\n\
        `cfg=4,6` makes `multiswitch.0` with four positions and `multiswitch.1` with six; without \
        it there is one with four.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt multiswitch cfg=3\n\
        loadrt threads name1=servo period1=1000000\n\
        addf multiswitch.0 servo\n\
        start\n\
        run 1ms\n\
        getp multiswitch.0.bit-00 # -> TRUE\n\
        setp multiswitch.0.up 1\n\
        run 1ms\n\
        getp multiswitch.0.bit-00 # -> FALSE\n\
        getp multiswitch.0.bit-01 # -> TRUE\n\
        getp multiswitch.0.position # -> 1\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::ints("cfg", "Number of positions of each switch, 1 to 32; 0 is 4.")
            .at_most(INSTANCES),
        &Arg::ints("personality", "Accepted for compatibility and ignored: cfg= counts."),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let mut sizes = b.arg_ints("cfg");
        if sizes.is_empty() {
            sizes.push(DEFAULT);
        }
        for n in sizes.iter_mut().filter(|n| **n == 0) {
            *n = DEFAULT;
        }
        if let Some(n) = sizes.iter().find(|n| !(1..=MAX).contains(*n)) {
            let text =
                format!("cfg={n} is not a number of positions, 1 to {MAX}, or 0 for {DEFAULT}");
            return Err(Error::new(text));
        }
        for (i, n) in sizes.into_iter().enumerate() {
            switch(b, &format!("multiswitch.{i}"), n)?;
        }
        Ok(())
    }
}

/// Declares one switch.
fn switch(b: &mut Builder<'_>, name: &str, n: i64) -> Result<(), Error> {
    let up = b.item(&format!("{name}.up"), "A rising edge moves to the next position.", false)?;
    let back = "A rising edge moves to the previous position.";
    let down = b.item(&format!("{name}.down"), back, false)?;
    let mut bits = Vec::new();
    for i in 0..n {
        let doc = "True while the switch is at this position.";
        bits.push(b.item(&format!("{name}.bit-{i:02}"), doc, false)?);
    }
    let last = u32::try_from(n - 1).unwrap_or_default();
    let doc = "The last position, from 0; one beyond the outputs is a position with none true.";
    let top = b.item(&format!("{name}.top-position"), doc, last)?;
    let doc = "The position, from 0; it may be set. Beyond the last it is taken as the first, \
        below 0 as the last.";
    let position = b.item(&format!("{name}.position"), doc, 0)?;
    let run = Switch { up, down, bits, top, position, was_up: false, was_down: false };
    b.function(name, "Moves the switch.", run)
}

/// Switch of one instance.
#[derive(Touch)]
struct Switch {
    up: In<bool>,
    down: In<bool>,
    bits: Vec<Out<bool>>,
    top: ParamRw<u32>,
    position: ParamRw<i32>,
    #[state]
    was_up: bool,
    #[state]
    was_down: bool,
}

impl Update for Switch {
    fn update(&mut self, _: Period) {
        let (up, down) = (self.up.get(), self.down.get());
        let (rises, falls) = (up && !self.was_up, down && !self.was_down);
        (self.was_up, self.was_down) = (up, down);
        let moved =
            self.position.get().wrapping_add(i32::from(rises)).wrapping_sub(i32::from(falls));
        let top = self.top.get().cast_signed();
        let position = if moved < 0 {
            top
        } else if moved.cast_unsigned() > self.top.get() {
            0
        } else {
            moved
        };
        self.position.set(position);
        let chosen = usize::try_from(position).ok();
        for (i, bit) in self.bits.iter().enumerate() {
            bit.set(chosen == Some(i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Multiswitch;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn it_goes_round_both_ways() {
        let rows = replay::<Multiswitch>(
            "load multiswitch cfg=3
             run multiswitch.0
             in multiswitch.0.up multiswitch.0.down
             out multiswitch.0.bit-00 multiswitch.0.bit-01 multiswitch.0.bit-02 multiswitch.0.position
             0 0 | 1 0 0 0
             1 0 | 0 1 0 1
             1 0 | 0 1 0 1
             0 0 | 0 1 0 1
             1 0 | 0 0 1 2
             0 0 | 0 0 1 2
             1 0 | 1 0 0 0
             0 1 | 0 0 1 2
             0 0 | 0 0 1 2
             1 1 | 0 0 1 2
             set multiswitch.0.position 9
             0 0 | 1 0 0 0
             set multiswitch.0.position -9
             0 0 | 0 0 1 2
             set multiswitch.0.top-position 5
             1 0 | 0 0 0 3
             0 0 | 0 0 0 3",
        );
        assert_eq!(rows, 14);
    }

    #[test]
    fn sizes() {
        let mut bench = Bench::new();
        bench.load::<Multiswitch>(&["cfg=1,32"]).unwrap();
        assert_eq!(bench.functs(), ["multiswitch.0", "multiswitch.1"]);
        // As in LinuxCNC, 0 is the default.
        let mut bench = Bench::new();
        bench.load::<Multiswitch>(&["cfg=0,2"]).unwrap();
        let is_output = |name: &&String| name.contains(".bit-");
        assert_eq!(bench.names().iter().filter(is_output).count(), 4 + 2);
        for wrong in ["cfg=33", "cfg=4,-1"] {
            let mut bench = Bench::new();
            let said = bench.load::<Multiswitch>(&[wrong]).unwrap_err();
            assert!(said.ends_with("is not a number of positions, 1 to 32, or 0 for 4"), "{said}");
            assert!(bench.names().is_empty());
        }
    }
}

//! `stepgen`.

use crate::{
    capture::{Capture, CapturePosition},
    freq::{Freq, Scale, UpdateFreq},
    handover::{Base, Made, Wanted},
    params::Params,
    pulses::{MakePulses, Pulses},
    types::{Control, StepType},
};
use hal_component::{
    Arg, Builder, Component, Decl, Error, Field,
    abi::{ArgSpec, component_flags},
};

/// Step pulse generators.
#[derive(Debug)]
pub enum Stepgen {}

const DOC: &str = "\
Step pulses for up to 16 motors, made in software.

Each channel follows a commanded position or speed within its limits of speed and acceleration,
and shows its steps as pulses or as motor phases. `stepgen.make-pulses` belongs in the fastest
thread; `stepgen.update-freq` and `stepgen.capture-position` in a slower one, capture first.

| type | outputs | cycle, in bits of the phases (A is 1) |
|---|---|---|
| 0 | step, dir | |
| 1 | up, down | |
| 2 | quadrature, A leads forward | 1 3 2 0 |
| 3 | three phases, full step | 1 2 4 |
| 4 | three phases, half step | 1 3 2 6 4 5 |
| 5 | four phases, full step, one on | 1 2 4 8 |
| 6 | four phases, full step, two on | 3 6 12 9 |
| 7 | four phases, bipolar full step | 1 7 14 8 |
| 8 | four phases, bipolar full step | 5 6 10 9 |
| 9 | four phases, unipolar half step | 1 3 2 6 4 12 8 9 |
| 10 | four phases, bipolar half step | 1 5 7 6 14 10 8 9 |
| 11 | five phases, unipolar full step | 1 2 4 8 16 |
| 12 | five phases, wave full step | 3 6 12 24 17 |
| 13 | five phases, unipolar half step | 1 3 2 6 4 12 8 24 16 17 |
| 14 | five phases, wave half step | 3 7 6 14 12 28 24 25 17 19 |
| 15 | as many phases as `user_step_type` uses | `user_step_type` |

The fastest rate is one step per `steplen` + `stepspace` (`steplen` alone for types 2 to 15); both
count in whole periods of make-pulses. A reversal waits until `dirhold` and `dirsetup` (`dirdelay`)
have passed, and the position waits with it; where the last step is longer ago than that, it begins at once. While `enable` is false a channel stands still at once.

# Pins

```hal
loadrt stepgen step_type=1
loadrt stepgen step_type=14
loadrt stepgen step_type=0 ctrl_type=v
```

# Example

```hal
loadrt stepgen step_type=0
loadrt threads name1=base period1=50000 name2=servo period2=1000000
addf stepgen.make-pulses base
addf stepgen.capture-position servo
addf stepgen.update-freq servo
start
setp stepgen.0.position-scale 1000
setp stepgen.0.maxvel 5
setp stepgen.0.maxaccel 50
setp stepgen.0.enable 1
setp stepgen.0.position-cmd 2
run 2s
getp stepgen.0.counts # -> 2000
getp stepgen.0.dir # -> FALSE
```";

const TYPES: ArgSpec = Arg::ints("step_type", "The type of each channel; -1 ends the list")
    .required()
    .within(-1.0, 15.0)
    .at_most(16);
const CONTROLS: ArgSpec = Arg::texts(
    "ctrl_type",
    "For each channel p: follows a position, v: follows a speed; p where the list is shorter",
)
.at_most(16);
const USER: ArgSpec = Arg::ints(
    "user_step_type",
    "The cycle of type 15: the bits of its phases in each state; -1 ends the list",
)
.within(-1.0, 31.0)
.at_most(18);

impl Component for Stepgen {
    const NAME: &'static str = "stepgen";
    const DOC: &'static str = DOC;
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[&TYPES, &CONTROLS, &USER];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let types = StepType::parse(&b.arg_ints("step_type"), &b.arg_ints("user_step_type"))?;
        let words = b.arg_texts("ctrl_type");
        let words = (0..).map(|n| words.get(n).map(String::as_str));
        let controls: Result<Vec<_>, _> =
            words.take(types.len()).enumerate().map(|(n, w)| Control::parse(n, w)).collect();

        let (gives_base, takes_base) = b.shared(Base::default());
        let mut pulses =
            MakePulses { channels: Vec::with_capacity(types.len()), base: gives_base, base_ns: 0 };
        let mut freqs = UpdateFreq { channels: Vec::with_capacity(types.len()), base: takes_base };
        let mut captures = CapturePosition { channels: Vec::with_capacity(types.len()) };
        for (number, (kind, control)) in types.iter().zip(controls?).enumerate() {
            let (asks, asked) = b.shared(Wanted::default());
            let (makes, made) = b.shared(Made::default());
            let c = &mut Channel { b, number };
            let enable = c.item("enable", ENABLE, false)?;
            let scale = Scale(c.item("position-scale", SCALE, 1.0)?);
            let params = Params::new(c, kind)?;
            let shared = (enable, params.clone());
            pulses.channels.push(Pulses::new(c, kind, shared, (asked, makes))?);
            let shared = (enable, params, scale);
            freqs.channels.push(Freq::new(c, control, shared, (asks, made.clone()))?);
            captures.channels.push(Capture::new(c, scale, made)?);
        }
        b.fast_function("stepgen.make-pulses", "Makes the pulses of all channels", pulses)?;
        b.function("stepgen.update-freq", "Turns commands into step rates", freqs)?;
        b.function("stepgen.capture-position", "Reports the positions of all channels", captures)
    }
}

const ENABLE: &str = "While true the channel makes steps; when it becomes false they stop at once";
const SCALE: &str = "Steps per length unit, for commands and feedback; negative: reversed. A value \
    smaller than 1e-20 becomes 1";

/// Channel during its creation.
pub(crate) struct Channel<'c, 'h> {
    pub(crate) b: &'c mut Builder<'h>,
    pub(crate) number: usize,
}

impl Channel<'_, '_> {
    pub(crate) fn item<F: Field>(
        &mut self,
        name: &str,
        doc: &str,
        initial: F::Value,
    ) -> Result<F, Error> {
        let name = format!("stepgen.{}.{name}", self.number);
        F::make(self.b, Decl::new(&name, doc), initial)
    }
}

#[cfg(test)]
mod tests {
    use super::Stepgen;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Stepgen>(include_str!("../traces/stepgen.txt")), 47);
    }
}

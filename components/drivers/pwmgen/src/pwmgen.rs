//! `pwmgen`.
use crate::{
    handover::{Base, Wanted},
    pulses::{Channel, MakePulses, Outputs},
    update::{Duty, UpdateDuty},
};
use hal_component::{
    Arg, Builder, Component, Error, In, Io, Out,
    abi::{ArgSpec, component_flags},
    pins,
};

/// PWM and PDM generators.
#[derive(Debug)]
pub enum Pwmgen {}

impl Component for Pwmgen {
    const NAME: &'static str = "pwmgen";
    const DOC: &'static str = "Generates pulses whose width or density follows a number: PWM and \
        PDM.\n\n\
        `output_type=0,1,2` makes three channels: type 0 has one output `pwm`, which is false for \
        negative values; type 1 `pwm` and `dir`, which is true for them; type 2 `up` and `down`. At \
        most 8. `pwmgen.make-pulses` belongs in the fastest thread, `pwmgen.update` in a slower \
        one.\n\n\
        The duty cycle is `value` / `scale` + `offset`, within `min-dc` and `max-dc` to either side. \
        With `pwm-freq` 0 there are no periods: pulses of one run each come as often as it takes.\n\n\
        # Pins\n\n\
        ```hal\n\
        loadrt pwmgen output_type=0\n\
        loadrt pwmgen output_type=2\n\
        ```\n\n\
        # Example\n\n\
        ```hal\n\
        # Half of the time forward: as a density, every other run.\n\
        loadrt pwmgen output_type=1\n\
        loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
        addf pwmgen.make-pulses base\n\
        addf pwmgen.update servo\n\
        start\n\
        setp pwmgen.0.scale 10\n\
        setp pwmgen.0.value -5\n\
        setp pwmgen.0.enable 1\n\
        run 10ms\n\
        getp pwmgen.0.dir # -> TRUE\n\
        getp pwmgen.0.curr-dc # -> -0.5\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::ints("output_type", "The type of each channel; -1 ends the list.")
            .within(-1.0, 2.0)
            .at_most(8)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let types: Vec<i64> =
            b.arg_ints("output_type").into_iter().take_while(|t| *t != -1).collect();
        if types.is_empty() {
            return Err(Error::new("PWMGEN: ERROR: no channels configured"));
        }
        let (gives_base, takes_base) = b.shared(Base::default());
        let mut make = MakePulses { channels: Vec::with_capacity(types.len()), base: gives_base };
        let mut update =
            UpdateDuty { channels: Vec::with_capacity(types.len()), base: takes_base, base_was: 0 };
        for (n, kind) in types.iter().enumerate() {
            let prefix = format!("pwmgen.{n}");
            let pins = Pins::make(b, &prefix)?;
            let output = |b: &mut Builder<'_>, name: &str, doc: &str| {
                b.item(&format!("{prefix}.{name}"), doc, false)
            };
            let dir = match kind {
                1 => Some(output(b, "dir", "True for negative values.")?),
                _ => None,
            };
            let outputs = match kind {
                2 => Outputs::UpDown {
                    up: output(b, "up", "The pulses for positive values.")?,
                    down: output(b, "down", "The pulses for negative values.")?,
                },
                _ => Outputs::One { pwm: output(b, "pwm", "The pulses.")? },
            };
            let (gives, takes) = b.shared(Wanted::default());
            make.channels.push(Channel::new(outputs, takes));
            update.channels.push(Duty::new(pins, dir, *kind == 0, gives));
        }
        b.fast_function("pwmgen.make-pulses", "Makes the pulses of all channels.", make)?;
        b.function("pwmgen.update", "Turns values into duty cycles.", update)
    }
}

pins! {
    /// Pins that all types have.
    pub(crate) struct Pins {
        /// Enables the pulses.
        enable: In<bool> = "enable", false;
        /// Requested duty cycle, in the unit of `scale`.
        value: In<f64> = "value", 0.0;
        /// Value at a duty cycle of 1, in the unit of `value`. A scale closer to 0 than 1e-20 is set to 1.
        scale: Io<f64> = "scale", 1.0;
        /// Offset added to the duty cycle, as a fraction.
        offset: Io<f64> = "offset", 0.0;
        /// TRUE: a width between two whole numbers of thread cycles is made by alternating between both.
        dither_pwm: Io<bool> = "dither-pwm", false;
        /// PWM frequency in hertz, corrected to the possible range; 0 selects pulse-density modulation.
        pwm_freq: Io<f64> = "pwm-freq", 0.0;
        /// Minimum duty cycle, a fraction: 0 to `max-dc`.
        min_dc: Io<f64> = "min-dc", 0.0;
        /// Maximum duty cycle, a fraction: `min-dc` to 1.
        max_dc: Io<f64> = "max-dc", 1.0;
        /// Present duty cycle, from -1 to 1; negative: backward.
        curr_dc: Out<f64> = "curr-dc", 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::Pwmgen;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Pwmgen>(include_str!("../traces/pwmgen.txt")), 2707);
    }

    #[test]
    fn types() {
        for (types, wanted) in [
            ("0", Ok(10)),
            ("0,1,2", Ok(32)),
            ("0,2,-1,1", Ok(21)),
            ("-1", Err("PWMGEN: ERROR: no channels configured")),
            ("0,3", Err("`3' out of range for parameter `output_type=0,3'")),
        ] {
            let mut bench = Bench::new();
            let made = bench.load::<Pwmgen>(&[&format!("output_type={types}")]);
            let made = made.map(|()| bench.names().len());
            assert_eq!(made, wanted.map_err(str::to_owned), "{types}");
        }
        let nothing = Bench::new().load::<Pwmgen>(&[]).unwrap_err();
        assert_eq!(nothing, "PWMGEN: ERROR: no channels configured");
    }
}

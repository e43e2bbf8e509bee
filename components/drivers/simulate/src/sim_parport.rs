//! `sim_parport`.
use hal_component::{
    Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, abi::component_flags,
};

/// Pins with the names of those of a parallel port.
pub(crate) struct SimParport;

const OUTPUTS: [u8; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 14, 16, 17];
const INPUTS: [u8; 13] = [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15];

impl Component for SimParport {
    const NAME: &'static str = "sim_parport";
    const DOC: &'static str = "Simulated parallel port: pins with the names of a real one.\n\n\
        With `names=parport.0` a script that was written for `hal_parport` finds its pins, those of all \
        its modes. Each has a partner whose name ends with `-fake`: what is written to an output \
        comes out there, and an input shows what its partner is given.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt sim_parport names=parport.0\n\
        loadrt threads name1=servo period1=1000000\n\
        addf parport.0.read servo\n\
        addf parport.0.write servo\n\
        setp parport.0.pin-10-in-fake 1\n\
        setp parport.0.pin-02-out-invert 1\n\
        start\n\
        run 1ms\n\
        getp parport.0.pin-10-in # -> TRUE\n\
        getp parport.0.pin-02-out-fake # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let mut write = Write { outputs: Vec::new() };
        for n in OUTPUTS {
            write.outputs.push(Output {
                out: b.item(&format!("pin-{n:02}-out"), "Level to output on the line.", false)?,
                fake: b.item(&format!("pin-{n:02}-out-fake"), "Level of the line.", false)?,
                invert: b.item(
                    &format!("pin-{n:02}-out-invert"),
                    "True inverts the line.",
                    false,
                )?,
            });
            let _: ParamRw<bool> = b.item(
                &format!("pin-{n:02}-out-reset"),
                "Without effect; exists only for scripts that set it.",
                false,
            )?;
        }
        let mut read = Read { inputs: Vec::new() };
        for n in INPUTS {
            read.inputs.push(Input {
                fake: b.item(&format!("pin-{n:02}-in-fake"), "Level of the line.", false)?,
                is: b.item(&format!("pin-{n:02}-in"), "Level of the line.", false)?,
                not: b.item(&format!("pin-{n:02}-in-not"), "Inverted level of the line.", false)?,
            });
        }
        let _: In<f64> =
            b.item("reset-time", "Without effect; exists only for scripts that set it.", 0.0)?;
        b.fast_function("read", "Reads the lines.", read)?;
        b.fast_function("write", "Writes the lines.", write)?;
        b.fast_function("reset", "Does nothing.", Reset {})
    }
}

#[derive(Touch)]
struct Input {
    fake: In<bool>,
    is: Out<bool>,
    not: Out<bool>,
}

#[derive(Touch)]
struct Read {
    inputs: Vec<Input>,
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        for line in &self.inputs {
            line.is.set(line.fake.get());
            line.not.set(!line.fake.get());
        }
    }
}

#[derive(Touch)]
struct Output {
    out: In<bool>,
    fake: Out<bool>,
    invert: ParamRw<bool>,
}

#[derive(Touch)]
struct Write {
    outputs: Vec<Output>,
}

impl Update for Write {
    fn update(&mut self, _: Period) {
        for line in &self.outputs {
            line.fake.set(line.out.get() != line.invert.get());
        }
    }
}

#[derive(Touch)]
struct Reset {}

impl Update for Reset {
    fn update(&mut self, _: Period) {}
}

#[cfg(test)]
mod tests {
    use super::SimParport;
    use hal_bench::trace::replay;

    #[test]
    fn lines_go_through() {
        let rows = "load sim_parport names=parport.1
            run parport.1.read parport.1.write parport.1.reset
            in parport.1.pin-15-in-fake parport.1.pin-17-out parport.1.pin-17-out-invert parport.1.pin-17-out-reset
            out parport.1.pin-15-in parport.1.pin-15-in-not parport.1.pin-17-out-fake parport.1.pin-17-out
            0 0 0 0 | 0 1 0 0
            1 1 0 0 | 1 0 1 1
            1 1 1 0 | 1 0 0 1
            0 0 1 1 | 0 1 1 0";
        assert_eq!(replay::<SimParport>(rows), 4);
    }
}

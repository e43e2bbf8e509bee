//! Component `hal_gpio`.

use crate::{
    chips::Chips,
    config::{self, GpioConfig},
    device::{Device, Written},
    encoder::{Encoder, EncoderPins},
    functions::{EdgeRoom, GpioCapture, GpioRead, GpioReset, GpioWrite, InputPins},
    kernel::Kernel,
};
use hal_component::{
    Arg, Builder, Component, Error, In, ParamRw,
    abi::{ArgSpec, component_flags},
};
use port::Report;
use std::sync::Arc;

/// Component `hal_gpio`.
pub(crate) enum HalGpio {}

impl Component for HalGpio {
    const NAME: &'static str = "hal_gpio";
    const DOC: &'static str = "\
GPIO lines of a single-board computer, or of any other chip that Linux has a GPIO driver for.

Lines are named as `gpioinfo` shows them, such as `GPIO17`; a line without a name, or with the name
of another one, is `gpiochipN.LINE`, such as `gpiochip0.17`. Lists have commas and no blanks.

| argument | lines |
|---|---|
| `inputs` | read by `hal_gpio.read`: pins `hal_gpio.NAME-in` and `hal_gpio.NAME-in-not` |
| `outputs` | written by `hal_gpio.write`: pins `hal_gpio.NAME-out` |
| `invert` | outputs whose line is low when their pin is TRUE |
| `reset` | outputs that `hal_gpio.reset` returns to rest, `hal_gpio.reset_ns` after the write |
| `opendrain`, `opensource` | outputs that drive low alone, or high alone |
| `pullup`, `pulldown`, `biasdisable` | lines with this resistor of the chip, or without one |
| `activelow` | lines of which TRUE is low; for inputs, what `invert` is for outputs |
| `debounce` | `NAME:MICROSECONDS`: inputs whose level counts once it has lasted for so long |
| `encoders` | `A:B`, `A:B:INDEX`, or a single line whose rising edges are counted |

The last three are not in LinuxCNC, which has the others. It ignores `invert` and `reset` for an
input; so does Ferrule, which says so.

A function takes one system call for up to 64 lines of a chip: microseconds on a board's own lines, and
about a millisecond on chips behind I2C or USB, which belong in a slow thread.

`hal_gpio.capture-position` counts encoders from edges that the kernel notes with their time. It may
therefore run in the servo thread, far more seldom than the edges come: up to 1024 of them between two
runs; `lost` counts those that were too many. The chip must be able to interrupt. The pins are
`hal_gpio.encoder.N.*`, and each encoder takes one system call.

`hal_gpio.reset` belongs after `hal_gpio.write` in the same thread: a step pulse in every period. It
waits at most a quarter of the period, and not at all in virtual time. The parameter
`hal_gpio.NAME-out-reset` of each line of `reset` turns this off and on.

The lines need a user in group `gpio`, and Linux 5.10 or later. A line that another program holds is
refused with its name. `hal_gpio.fault` is TRUE while a chip does not answer, for instance because it
was unplugged: inputs keep their values then, and the motion controller is off. Wire the pin to the
e-stop for what moves without that controller.

All outputs are FALSE from the moment of the load, and go to FALSE when the machine stops, and before
the lines are released, also by a signal or a crash. A `kill -9` leaves no time for that: the kernel
releases the lines, and their chip's driver decides. Raspberry Pi's kernels keep the last levels, unless
`dtparam=strict_gpiod` is in config.txt; then, and with most other kernels, the lines become inputs.
Wire them so that an open line is safe, and use a charge pump.

Simulated lines are the pins `hal_gpio.sim.NAME`, as levels on the wire: TRUE is high.
`hal_gpio.sim.vanished` makes every access fail as if the chip had been unplugged.

# Pins

```hal
loadrt hal_gpio inputs=GPIO5 outputs=GPIO17 reset=GPIO17 encoders=GPIO23:GPIO24
```

# Example

```hal
# On simulated hardware the lines are pins.
loadrt hal_gpio inputs=GPIO5,GPIO6 outputs=GPIO17,GPIO27 invert=GPIO27
loadrt threads name1=servo period1=1000000
addf hal_gpio.read servo
addf hal_gpio.write servo
start
setp hal_gpio.GPIO17-out 1
setp hal_gpio.sim.GPIO6 1
run 1ms
getp hal_gpio.GPIO6-in # -> TRUE
getp hal_gpio.sim.GPIO17 # -> TRUE
getp hal_gpio.sim.GPIO27 # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::texts("inputs", "Names of input lines, such as GPIO5,GPIO6.").at_most(128),
        &Arg::texts("outputs", "Names of output lines, such as GPIO17.").at_most(128),
        &Arg::texts("invert", "Outputs whose line is low when their pin is TRUE.").at_most(128),
        &Arg::texts("reset", "Outputs that `hal_gpio.reset` returns to rest.").at_most(128),
        &Arg::texts("opendrain", "Outputs that drive low alone.").at_most(128),
        &Arg::texts("opensource", "Outputs that drive high alone.").at_most(128),
        &Arg::texts("biasdisable", "Lines without a resistor of the chip.").at_most(128),
        &Arg::texts("pulldown", "Lines with a resistor to low.").at_most(128),
        &Arg::texts("pullup", "Lines with a resistor to high.").at_most(128),
        &Arg::texts("activelow", "Lines of which TRUE is low.").at_most(128),
        &Arg::texts("debounce", "Inputs and how long a level must last, as NAME:MICROSECONDS.")
            .at_most(128),
        &Arg::texts("encoders", "Encoders as A:B or A:B:INDEX, and counters as a single line.")
            .at_most(128),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let config =
            config::parse(|arg| b.arg_texts(arg)).map_err(|why| Error::new(why.to_string()))?;
        if config.is_without_effect {
            b.messages().notice(WITHOUT_EFFECT, &[]);
        }
        declare(b, "hal_gpio", config, true, Kernel::default())
    }
}

const WITHOUT_EFFECT: &str = "invert= or reset= names an input, where it has no effect, as in LinuxCNC: \
                              activelow= and the pin NAME-in-not invert an input";

/// Declares pins and functions of lines of these chips. `has_not` adds a pin with the opposite of each input.
pub(crate) fn declare(
    b: &mut Builder<'_>,
    prefix: &'static str,
    config: GpioConfig,
    has_not: bool,
    chips: impl Chips + Send + 'static,
) -> Result<(), Error> {
    let device = Arc::new(Device::new(config));
    let config = device.config();
    let (mut inputs, mut outputs, mut marks) = (Vec::new(), Vec::new(), Vec::new());
    for line in &config.lines {
        let name = line.name;
        let (mut input, mut output, mut mark) = (None, None, None);
        if line.setting.is_output {
            let inverts = if line.setting.is_active_low { "low" } else { "high" };
            let about = format!("Level that the next write gives line {name}: TRUE is {inverts}");
            output = Some(b.item::<bool, _>(&format!("{prefix}.{name}-out"), &about, false)?);
            if line.is_reset {
                let about = format!("TRUE makes {prefix}.reset return line {name} to rest");
                mark = Some(b.item(&format!("{prefix}.{name}-out-reset"), &about, true)?);
            }
        } else if !line.setting.has_edges {
            let high = if line.setting.is_active_low { "low" } else { "high" };
            let about = format!(
                "Level of line {name} at the last read: TRUE is {high}; FALSE before the first"
            );
            let level = b.item(&format!("{prefix}.{name}-in"), &about, false)?;
            let mut not = None;
            if has_not {
                let about =
                    format!("The opposite of {name}-in; FALSE as well before the first read");
                not = Some(b.item(&format!("{prefix}.{name}-in-not"), &about, false)?);
            }
            input = Some(InputPins { level, not });
        }
        inputs.push(input);
        outputs.push(output);
        marks.push(mark);
    }
    let encoders = encoders(b, prefix, config)?;
    functions(b, prefix, &device, Parts { inputs, outputs, marks, encoders })?;

    let opened = device.clone();
    b.on_open(move |_| opened.open(&chips).map_err(|why| Error::new(why.to_string())))?;
    b.on_stop(move || {
        // A lost chip cannot be stopped; the write function reports it.
        let _ = device.rest();
    })
}

fn encoders(b: &mut Builder<'_>, prefix: &str, config: &GpioConfig) -> Result<Vec<Encoder>, Error> {
    let mut encoders = Vec::new();
    for (number, lines) in config.encoders.iter().enumerate() {
        let pins = EncoderPins::make(b, &format!("{prefix}.encoder.{number}"))?;
        encoders.push(Encoder::new(pins, b.messages(), number, lines.b.is_some()));
    }
    Ok(encoders)
}

/// Pins of the lines, by their places in the list of lines, and encoders.
struct Parts {
    inputs: Vec<Option<InputPins>>,
    outputs: Vec<Option<In<bool>>>,
    /// Parameters of the outputs that the reset function may return to rest.
    marks: Vec<Option<ParamRw<bool>>>,
    encoders: Vec<Encoder>,
}

fn functions(
    b: &mut Builder<'_>,
    prefix: &str,
    device: &Arc<Device>,
    Parts { inputs, outputs, marks, encoders }: Parts,
) -> Result<(), Error> {
    let about = "TRUE while a chip does not answer";
    let fault = b.item(&format!("{prefix}.fault"), about, false)?;
    let [mut edges, sets] =
        if b.is_simulated() { device.simulate(b, prefix)? } else { [Vec::new(), Vec::new()] };
    // The lines of encoders come first.
    let levels = edges.split_off(encoders.len().min(edges.len()));
    let (written, taken) = b.shared(Written::default());
    let (clock, report) = (b.clock(), Report::new(b, 0));
    // There are at most as many groups of lines as lines.
    let reports = vec![report; device.config().lines.len()];
    let read = GpioRead {
        device: device.clone(),
        inputs,
        simulated: levels,
        fault,
        written: written.clone(),
        reports: reports.clone(),
    };
    b.function(&format!("{prefix}.read"), "Reads the inputs", read)?;
    if !encoders.is_empty() {
        let capture = GpioCapture {
            device: device.clone(),
            encoders,
            simulated: edges,
            fault,
            written: written.clone(),
            reports: reports.clone(),
            edges: EdgeRoom::default(),
        };
        let about = "Counts the edges of encoders=: positions and speeds";
        b.function(&format!("{prefix}.capture-position"), about, capture)?;
    }
    if marks.iter().any(Option::is_some) {
        let about = "Nanoseconds from write to reset; 0 to a quarter of the period, above which the \
                     reset function sets it to that. In virtual time the reset does not wait";
        let reset = GpioReset {
            device: device.clone(),
            time: b.item(&format!("{prefix}.reset_ns"), about, 0)?,
            marks,
            simulated: sets.clone(),
            fault,
            written: taken,
            clock,
            reports: reports.clone(),
        };
        let about = "Returns the outputs of reset= to rest, reset_ns after they were written";
        b.fast_function(&format!("{prefix}.reset"), about, reset)?;
    }
    let write = GpioWrite {
        device: device.clone(),
        outputs,
        simulated: sets,
        fault,
        written,
        clock,
        reports,
    };
    b.function(&format!("{prefix}.write"), "Writes the outputs", write)
}

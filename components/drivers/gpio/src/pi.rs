//! Component `hal_pi_gpio`.

use crate::{
    config::{GpioConfig, NamedLine, Place, Setting},
    gpio::declare,
    kernel::Kernel,
    label::Label,
};
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};

/// Component `hal_pi_gpio`.
pub(crate) enum PiGpio {}

/// Lines in the order of the bits of `dir` and `exclude`, which is LinuxCNC's: number of the line, and its pin on the
/// 40-pin header. Bits 19 and 20 are lines 22 and 21.
pub(crate) const HEADER: [(u32, u8); 26] = [
    (2, 3),
    (3, 5),
    (4, 7),
    (5, 29),
    (6, 31),
    (7, 26),
    (8, 24),
    (9, 21),
    (10, 19),
    (11, 23),
    (12, 32),
    (13, 33),
    (14, 8),
    (15, 10),
    (16, 36),
    (17, 11),
    (18, 12),
    (19, 35),
    (20, 38),
    (22, 15),
    (21, 40),
    (23, 16),
    (24, 18),
    (25, 22),
    (26, 37),
    (27, 13),
];

impl Component for PiGpio {
    const NAME: &'static str = "hal_pi_gpio";
    const DOC: &'static str = "\
GPIO lines of a Raspberry Pi by their pins on the 40-pin header.

`dir` and `exclude` are masks, in decimal or with `0x`, as in LinuxCNC: a bit for each line, from
GPIO2 in bit 0 to GPIO27 in bit 25, in order except that bit 19 is GPIO22 and bit 20 is GPIO21. A
line is `hal_pi_gpio.pin-NN-out` or `-in`, where NN is the pin of the header:

| bits | lines | pins |
|---|---|---|
| 0 to 7 | GPIO2 to GPIO9 | 3, 5, 7, 29, 31, 26, 24, 21 |
| 8 to 15 | GPIO10 to GPIO17 | 19, 23, 32, 33, 8, 10, 36, 11 |
| 16 to 20 | GPIO18, 19, 20, 22, 21 | 12, 35, 38, 15, 40 |
| 21 to 25 | GPIO23 to GPIO27 | 16, 18, 22, 37, 13 |

Where LinuxCNC writes the registers of the board, this uses the kernel's GPIO interface, so that every
model from the B+ to the 5 works, and a line that a driver holds (I2C, SPI, the serial port) is refused
with its name. `hal_gpio` does more on the same lines: bias, debounce, encoders, a reset function.

The lines need a user in group `gpio`. `hal_pi_gpio.fault` is TRUE while the chip does not answer: the
motion controller is off then. All outputs are FALSE from the moment of the load, and go to FALSE when the machine stops, and before the
lines are released. Simulated lines are the pins `hal_pi_gpio.sim.pin-NN`.

# Pins

```hal
loadrt hal_pi_gpio dir=0 exclude=0
```

# Example

```hal
# Pin 3 is an output, pin 5 an input.
loadrt hal_pi_gpio dir=0x1 exclude=0x3FFFFFC
loadrt threads name1=servo period1=1000000
addf hal_pi_gpio.read servo
addf hal_pi_gpio.write servo
start
setp hal_pi_gpio.pin-03-out 1
setp hal_pi_gpio.sim.pin-05 1
run 1ms
getp hal_pi_gpio.pin-05-in # -> TRUE
getp hal_pi_gpio.sim.pin-03 # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("dir", "Mask of the outputs: 1 is an output, 0 an input; -1: all are outputs.")
            .within(-2_147_483_648.0, 4_294_967_295.0)
            .or("-1"),
        &Arg::int("exclude", "Mask of the lines that are left alone: 1 is left alone.")
            .within(-2_147_483_648.0, 4_294_967_295.0)
            .or("0"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let mask = |arg, default| b.arg_int(arg).unwrap_or(default);
        let (outputs, excluded) = (mask("dir", -1), mask("exclude", 0));
        let used = HEADER.iter().enumerate().filter(|(bit, _)| excluded >> bit & 1 == 0);
        let lines = used.map(|(bit, (line, pin))| NamedLine {
            name: Label::cut(&format!("pin-{pin:02}")),
            place: Place::Header(*line),
            setting: Setting { is_output: outputs >> bit & 1 != 0, ..Setting::default() },
            is_reset: false,
        });
        let config = GpioConfig { lines: lines.collect(), ..GpioConfig::default() };
        if config.lines.is_empty() {
            return Err(Error::new(NO_LINES));
        }
        declare(b, "hal_pi_gpio", config, false, Kernel::default())
    }
}

const NO_LINES: &str =
    "exclude= leaves no line of the header: of its bits 0 to 25 at least one must be 0";

//! Realtime. Lines of the connector as pins and parameters.

use hal_component::{Builder, Error, In, Out, ParamRw, Touch};

/// Line: its pin number on the connector, and its bit in the register.
pub(crate) type Line = (u8, u8);

/// Lines of the data register.
pub(crate) const DATA: &[Line] = &[(2, 0), (3, 1), (4, 2), (5, 3), (6, 4), (7, 5), (8, 6), (9, 7)];
/// Lines of the status register.
pub(crate) const STATUS: &[Line] = &[(15, 3), (13, 4), (12, 5), (10, 6), (11, 7)];
/// Lines of the control register.
pub(crate) const CONTROL: &[Line] = &[(1, 0), (14, 1), (16, 2), (17, 3)];

/// Input line.
#[derive(Clone, Touch)]
pub(crate) struct Input {
    #[state]
    mask: u8,
    level: Out<bool>,
    not: Out<bool>,
}

/// Output line.
#[derive(Clone, Touch)]
pub(crate) struct Output {
    #[state]
    mask: u8,
    value: In<bool>,
    invert: ParamRw<bool>,
}

/// Output line that may be reset, for the reset function.
#[derive(Clone, Touch)]
pub(crate) struct Pulse {
    #[state]
    mask: u8,
    reset: ParamRw<bool>,
    invert: ParamRw<bool>,
}

/// Declares the pins of input lines.
pub(crate) fn inputs(
    b: &mut Builder<'_>,
    port: usize,
    lines: &[Line],
) -> Result<Vec<Input>, Error> {
    let mut list = Vec::new();
    for (pin, bit) in lines {
        let name = format!("parport.{port}.pin-{pin:02}-in");
        let about = format!(
            "Level of connector pin {pin} at the last read: TRUE is high; FALSE before the first"
        );
        let level = b.item(&name, &about, false)?;
        let about = format!("The opposite of pin-{pin:02}-in; FALSE as well before the first read");
        let not = b.item(&format!("{name}-not"), &about, false)?;
        list.push(Input { mask: 1 << bit, level, not });
    }
    Ok(list)
}

/// Declares the pins and parameters of output lines.
pub(crate) fn outputs(
    b: &mut Builder<'_>,
    port: usize,
    lines: &[Line],
) -> Result<(Vec<Output>, Vec<Pulse>), Error> {
    let (mut outputs, mut pulses) = (Vec::new(), Vec::new());
    for (pin, bit) in lines {
        let (name, mask) = (format!("parport.{port}.pin-{pin:02}-out"), 1 << bit);
        let about = format!(
            "Level that the next write gives connector pin {pin}: TRUE is high, or low with \
             pin-{pin:02}-out-invert"
        );
        let value = b.item(&name, &about, false)?;
        let about = format!("TRUE makes pin-{pin:02}-out drive low when it is TRUE");
        let invert = b.item(&format!("{name}-invert"), &about, false)?;
        let about = format!(
            "TRUE makes parport.{port}.reset return connector pin {pin} to the level of FALSE"
        );
        let reset = b.item(&format!("{name}-reset"), &about, false)?;
        outputs.push(Output { mask, value, invert });
        pulses.push(Pulse { mask, reset, invert });
    }
    Ok((outputs, pulses))
}

/// Distributes a byte of levels to the pins.
pub(crate) fn take(lines: &[Input], levels: u8) {
    for line in lines {
        let high = levels & line.mask != 0;
        line.level.set(high);
        line.not.set(!high);
    }
}

/// Returns the levels that the pins request, and the levels with all pins FALSE.
pub(crate) fn levels(lines: &[Output]) -> (u8, u8) {
    lines.iter().fold((0, 0), |(wanted, idle), line| {
        let (value, invert) = (line.value.get(), line.invert.get());
        let bit = |on: bool| if on { line.mask } else { 0 };
        (wanted | bit(value != invert), idle | bit(invert))
    })
}

/// Returns `levels` with the lines that request it reset.
pub(crate) fn reset(lines: &[Pulse], levels: u8) -> u8 {
    let asking = lines.iter().filter(|line| line.reset.get());
    asking.fold(
        levels,
        |levels, line| {
            if line.invert.get() { levels | line.mask } else { levels & !line.mask }
        },
    )
}

//! Realtime. Lines of the connector as pins and parameters.

use hal_component::{
    Builder, Error, In, Out, ParamRw, Touch,
    abi::{ItemSpec, Str, dir, size, ty},
};

/// Input line: its pins, and its bit in the input registers.
#[derive(Touch)]
pub(crate) struct Input {
    #[state]
    register: usize,
    #[state]
    mask: u8,
    level: Out<bool>,
    not: Out<bool>,
}

/// Output line: its pin and parameter, and its bit in the output registers.
#[derive(Clone, Touch)]
pub(crate) struct Output {
    #[state]
    register: usize,
    #[state]
    mask: u8,
    value: In<bool>,
    invert: ParamRw<bool>,
}

/// Constant data of a line: its two items with their documentation, and its bit.
struct Line {
    first: (&'static str, &'static str),
    second: (&'static str, &'static str),
    register: usize,
    mask: u8,
}

macro_rules! input {
    ($n:literal, $signal:literal, $connector:literal, $register:literal, $mask:literal) => {
        Line {
            first: (
                concat!("viagpio.pin-", $n, "-in"),
                concat!(
                    "Level of ",
                    $signal,
                    " (connector pin ",
                    $connector,
                    ") at the last read: TRUE is high; FALSE before the first"
                ),
            ),
            second: (
                concat!("viagpio.pin-", $n, "-in-not"),
                concat!("The opposite of pin-", $n, "-in; FALSE as well before the first read"),
            ),
            register: $register,
            mask: $mask,
        }
    };
}

macro_rules! output {
    ($n:literal, $signal:literal, $connector:literal, $register:literal, $mask:literal) => {
        Line {
            first: (
                concat!("viagpio.pin-", $n, "-out"),
                concat!(
                    "Level that the next write gives ",
                    $signal,
                    " (connector pin ",
                    $connector,
                    "): TRUE is high, or low with pin-",
                    $n,
                    "-out-invert"
                ),
            ),
            second: (
                concat!("viagpio.pin-", $n, "-out-invert"),
                concat!("TRUE makes pin-", $n, "-out drive low when it is TRUE"),
            ),
            register: $register,
            mask: $mask,
        }
    };
}

const INPUTS: [Line; 4] = [
    input!("01", "GPI4", "24", 0, 0x10),
    input!("02", "GPI5", "22", 0, 0x20),
    input!("03", "GPI8", "18", 1, 0x01),
    input!("04", "GPI9", "20", 1, 0x02),
];

const OUTPUTS: [Line; 4] = [
    output!("05", "GPO12", "21", 2, 0x04),
    output!("06", "GPIO1", "23", 0, 0x10),
    output!("07", "GPIO9", "19", 1, 0x10),
    output!("08", "GPIO12", "17", 1, 0x80),
];

/// All pins and parameters, for programs that read the library without running it.
pub(crate) const ITEMS: &[&ItemSpec] = &[
    &bit(INPUTS[0].first, dir::OUT),
    &bit(INPUTS[0].second, dir::OUT),
    &bit(INPUTS[1].first, dir::OUT),
    &bit(INPUTS[1].second, dir::OUT),
    &bit(INPUTS[2].first, dir::OUT),
    &bit(INPUTS[2].second, dir::OUT),
    &bit(INPUTS[3].first, dir::OUT),
    &bit(INPUTS[3].second, dir::OUT),
    &bit(OUTPUTS[0].first, dir::IN),
    &bit(OUTPUTS[0].second, dir::RW),
    &bit(OUTPUTS[1].first, dir::IN),
    &bit(OUTPUTS[1].second, dir::RW),
    &bit(OUTPUTS[2].first, dir::IN),
    &bit(OUTPUTS[2].second, dir::RW),
    &bit(OUTPUTS[3].first, dir::IN),
    &bit(OUTPUTS[3].second, dir::RW),
];

const fn bit((name, doc): (&'static str, &'static str), dir: u8) -> ItemSpec {
    ItemSpec {
        size: size::<ItemSpec>(),
        flags: 0,
        name: Str::new(name),
        doc: Str::new(doc),
        old_name: Str::NONE,
        initial: 0,
        storage: core::ptr::null_mut(),
        ty: ty::BIT,
        dir,
    }
}

/// Declares the pins of the inputs.
pub(crate) fn inputs(b: &mut Builder<'_>) -> Result<Vec<Input>, Error> {
    let make = |Line { first, second, register, mask }| {
        let level = b.item(first.0, first.1, false)?;
        Ok(Input { register, mask, level, not: b.item(second.0, second.1, false)? })
    };
    INPUTS.into_iter().map(make).collect()
}

/// Declares the pins and parameters of the outputs.
pub(crate) fn outputs(b: &mut Builder<'_>) -> Result<Vec<Output>, Error> {
    let make = |Line { first, second, register, mask }| {
        let value = b.item(first.0, first.1, false)?;
        Ok(Output { register, mask, value, invert: b.item(second.0, second.1, false)? })
    };
    OUTPUTS.into_iter().map(make).collect()
}

/// Distributes the input registers to the pins.
pub(crate) fn take(lines: &[Input], registers: [u8; 2]) {
    for line in lines {
        let high = registers.get(line.register).is_some_and(|byte| byte & line.mask != 0);
        line.level.set(high);
        line.not.set(!high);
    }
}

/// Returns the levels of the output registers that the pins request, and those with all pins FALSE.
pub(crate) fn levels(lines: &[Output]) -> ([u8; 3], [u8; 3]) {
    let (mut wanted, mut idle) = ([0; 3], [0; 3]);
    for line in lines {
        let (value, invert) = (line.value.get(), line.invert.get());
        for (registers, high) in [(&mut wanted, value != invert), (&mut idle, invert)] {
            if let Some(byte) = registers.get_mut(line.register).filter(|_| high) {
                *byte |= line.mask;
            }
        }
    }
    (wanted, idle)
}

//! Arguments of `hy_vfd`.

use crate::line::{Parity, SerialPlace, is_name, is_path};
use core::fmt;
use hal_component::{Arg, Builder, abi::ArgSpec};
use hal_modbus::{huanyang::setting, nanoseconds};

/// Rates of PD164, from 0.
const RATES: [u32; 4] = [4800, 9600, 19200, 38400];
/// Longest name of an inverter.
const MAX_NAME: usize = 24;

pub(crate) const ARGS: &[&ArgSpec] = &[
    &Arg::bit(
        "task",
        "TRUE sets the pins every millisecond in the background, without a function.",
    )
    .or("FALSE"),
    &Arg::text("name", "Name before all pins, and of the function.").or("hy_vfd"),
    &Arg::text("device", "Serial line, best by its name in /dev/serial/by-id.").or("/dev/ttyS0"),
    &Arg::int("rate", "Bits per second (PD164): 4800, 9600, 19200 or 38400.").or("19200"),
    &Arg::int("bits", "Data bits.").within(5.0, 8.0).or("8"),
    &Arg::text("parity", "none, even or odd (PD165).").or("none"),
    &Arg::int("stopbits", "Stop bits.").within(1.0, 2.0).or("1"),
    &Arg::int("target", "Number of the inverter (PD163).").within(1.0, 250.0).or("1"),
    &Arg::float("timeout", "Time without an answer after which the inverter is lost.")
        .within(0.2, 10.0)
        .unit("s")
        .or("0.5"),
    &Arg::float("max_frequency", "Greatest frequency, written to PD005.")
        .within(1.0, 650.0)
        .unit("Hz"),
    &Arg::float("min_frequency", "Least frequency, written to PD011.")
        .within(0.0, 650.0)
        .unit("Hz"),
    &Arg::float("base_frequency", "Rated frequency of the motor, written to PD004.")
        .within(1.0, 650.0)
        .unit("Hz"),
    &Arg::float("motor_voltage", "Rated voltage of the motor, written to PD141.")
        .within(1.0, 1000.0)
        .unit("V"),
    &Arg::float("motor_current", "Rated current of the motor, written to PD142.")
        .within(0.1, 1000.0)
        .unit("A"),
    &Arg::float("motor_speed", "Turns per minute at max_frequency, from which PD144 is written.")
        .within(1.0, 120_000.0),
    &Arg::int("motor_poles", "Number of the motor's poles, written to PD143.").within(2.0, 100.0),
    &Arg::texts("register", "Settings to write, such as PD014=30,PD015=30.").at_most(10),
];

/// Arguments that were understood.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct HyConfig {
    pub(crate) name: String,
    pub(crate) unit: u8,
    pub(crate) place: SerialPlace,
    /// Settings to write, with their values.
    pub(crate) writes: Vec<(u8, u16)>,
    pub(crate) timeout_ns: i64,
    /// The pins are set in the background.
    pub(crate) is_task: bool,
}

/// Argument that is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum BadArgument {
    /// PD164 does not have this rate.
    Rate(i64),
    /// There is no such parity.
    Parity(String),
    /// A device that is no path.
    Device(String),
    /// A name that no pin can have.
    Name(String),
    /// A setting that is none.
    Register(String),
    /// The speed of the motor without its frequency.
    Speed,
    /// A value that a setting does not hold.
    TooLarge(u8),
}

impl fmt::Display for BadArgument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rate(rate) => {
                let all: Vec<String> = RATES.iter().map(ToString::to_string).collect();
                write!(f, "rate={rate}: the inverter has one of {} (PD164)", all.join(", "))
            }
            Self::Parity(text) => write!(f, "parity={text}: must be none, even or odd"),
            Self::Device(text) => {
                write!(
                    f,
                    "device={text}: must be a path of at most 255 letters, such as /dev/ttyUSB0"
                )
            }
            Self::Name(text) => write!(
                f,
                "name={text}: 1 to {MAX_NAME} letters, digits, '-', '_' and '.' are possible"
            ),
            Self::Register(text) => write!(
                f,
                "register={text}: PDnnn=VALUE is needed, such as PD014=30, from PD000 to PD255 and with a value from 0 to 65535"
            ),
            Self::Speed => f.write_str(
                "motor_speed= needs max_frequency=, the frequency at which the motor turns so fast",
            ),
            Self::TooLarge(number) => {
                write!(f, "the value for PD{number:03} is above 65535 of its units")
            }
        }
    }
}

impl core::error::Error for BadArgument {}

impl HyConfig {
    /// Reads the arguments.
    pub(crate) fn read(b: &Builder<'_>) -> Result<Self, BadArgument> {
        let text = |name| b.arg_text(name).unwrap_or_default();
        let byte = |name, or| b.arg_int(name).and_then(|n| u8::try_from(n).ok()).unwrap_or(or);
        let rate = b.arg_int("rate").unwrap_or(19200);
        let parity = text("parity");
        let name = text("name");
        if MAX_NAME < name.len() || !is_name(&name) {
            return Err(BadArgument::Name(name));
        }
        let path = text("device");
        if !is_path(&path) {
            return Err(BadArgument::Device(path));
        }
        let seconds = b.arg_float("timeout").unwrap_or(0.5);
        Ok(Self {
            name,
            unit: byte("target", 1),
            place: SerialPlace {
                path,
                rate: u32::try_from(rate)
                    .ok()
                    .filter(|rate| RATES.contains(rate))
                    .ok_or(BadArgument::Rate(rate))?,
                bits: byte("bits", 8),
                parity: Parity::of(&parity).ok_or(BadArgument::Parity(parity))?,
                stops: byte("stopbits", 1),
            },
            writes: writes(b)?,
            timeout_ns: nanoseconds(seconds),
            is_task: b.arg_int("task") == Some(1),
        })
    }
}

/// Returns the settings to write.
fn writes(b: &Builder<'_>) -> Result<Vec<(u8, u16)>, BadArgument> {
    let top = b.arg_float("max_frequency");
    let mut out = Vec::new();
    for (number, arg, scale) in [
        (setting::MAX_FREQUENCY, "max_frequency", 100.0),
        (setting::BASE_FREQUENCY, "base_frequency", 100.0),
        (setting::MIN_FREQUENCY, "min_frequency", 100.0),
        (setting::MOTOR_VOLTAGE, "motor_voltage", 10.0),
        (setting::MOTOR_CURRENT, "motor_current", 10.0),
    ] {
        if let Some(value) = b.arg_float(arg) {
            out.push((number, scaled(number, value * scale)?));
        }
    }
    if let Some(poles) = b.arg_int("motor_poles") {
        out.push((setting::MOTOR_POLES, u16::try_from(poles).unwrap_or_default()));
    }
    if let Some(speed) = b.arg_float("motor_speed") {
        let top = top.ok_or(BadArgument::Speed)?;
        out.push((setting::MOTOR_TURNS, scaled(setting::MOTOR_TURNS, speed * 50.0 / top)?));
    }
    for text in b.arg_texts("register") {
        out.push(register(&text).ok_or(BadArgument::Register(text))?);
    }
    Ok(out)
}

/// Returns a value as a setting has it.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within u16")]
fn scaled(number: u8, value: f64) -> Result<u16, BadArgument> {
    let whole = (value + 0.5).floor();
    if (0.0..=65535.0).contains(&whole) {
        Ok(whole as u16)
    } else {
        Err(BadArgument::TooLarge(number))
    }
}

/// Reads a setting such as `PD014=30`.
fn register(text: &str) -> Option<(u8, u16)> {
    let (number, value) = text.split_once('=')?;
    let number = number.strip_prefix("PD").or(number.strip_prefix('P')).unwrap_or(number);
    Some((number.parse().ok()?, value.parse().ok()?))
}

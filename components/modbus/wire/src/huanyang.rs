//! Frames of Huanyang's inverters.
//!
//! They end with the CRC of Modbus, and are something else: number of the device, function, number of data bytes, data.
//!
//! | function | request | answer |
//! |---|---|---|
//! | 1 read a setting | number, 0, 0 | number, value in one or two bytes |
//! | 2 write a setting | number, value | number, value |
//! | 3 control | command | state |
//! | 4 read a measurement | number | number, value |
//! | 5 set the frequency | frequency in 0.01 Hz | the same |
//!
//! Function 6 is reserved.

use crate::{Miss, is_whole, push_crc};

/// Command: run forward.
pub const RUN_FORWARD: u8 = 0x01;
/// Command: run in reverse.
pub const RUN_REVERSE: u8 = 0x11;
/// Command: stop.
pub const STOP: u8 = 0x08;

/// Bit of a command: run.
pub const COMMAND_RUN: u8 = 0x01;
/// Bit of a command: reverse.
pub const COMMAND_REVERSE: u8 = 0x10;

/// Number of bytes of the longest answer.
pub const MAX_ANSWER: usize = 8;

/// Numbers of settings (PD000 to PD255).
pub mod setting {
    /// Frequency at which the motor has its rated voltage, in 0.01 Hz.
    pub const BASE_FREQUENCY: u8 = 4;
    /// Greatest frequency, in 0.01 Hz.
    pub const MAX_FREQUENCY: u8 = 5;
    /// Least frequency, in 0.01 Hz.
    pub const MIN_FREQUENCY: u8 = 11;
    /// Time from rest to the greatest frequency, in 0.1 s.
    pub const ACCELERATION: u8 = 14;
    /// Time from the greatest frequency to rest, in 0.1 s.
    pub const DECELERATION: u8 = 15;
    /// Rated voltage of the motor, in 0.1 V.
    pub const MOTOR_VOLTAGE: u8 = 141;
    /// Rated current of the motor, in 0.1 A.
    pub const MOTOR_CURRENT: u8 = 142;
    /// Number of the motor's poles.
    pub const MOTOR_POLES: u8 = 143;
    /// Turns per minute of the motor at 50 Hz.
    pub const MOTOR_TURNS: u8 = 144;
}

/// Bits of the state, from the lowest.
pub mod state {
    /// The command was to run.
    pub const RUN: u8 = 0x01;
    /// The command was to jog.
    pub const JOG: u8 = 0x02;
    /// The command was to turn in reverse.
    pub const COMMAND_REVERSE: u8 = 0x04;
    /// The motor runs.
    pub const RUNNING: u8 = 0x08;
    /// The motor jogs.
    pub const JOGGING: u8 = 0x10;
    /// The motor runs in reverse.
    pub const RUNNING_REVERSE: u8 = 0x20;
    /// The inverter brakes.
    pub const BRAKING: u8 = 0x40;
    /// The inverter takes up a motor that turns.
    pub const TRACKING: u8 = 0x80;
}

/// Measurements, by their numbers.
pub mod measured {
    /// Frequency that is set, in 0.01 Hz.
    pub const SET_FREQUENCY: u8 = 0;
    /// Frequency at the output, in 0.01 Hz.
    pub const FREQUENCY: u8 = 1;
    /// Current, in 0.1 A.
    pub const CURRENT: u8 = 2;
    /// Turns per minute, which it calculates.
    pub const TURNS: u8 = 3;
    /// Voltage of its direct current.
    pub const DC: u8 = 4;
    /// Voltage of its output.
    pub const AC: u8 = 5;
    /// Counter.
    pub const COUNTER: u8 = 6;
    /// Temperature.
    pub const TEMPERATURE: u8 = 7;
}

/// Question of a master to an inverter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// Reads a setting (PD000 to PD255).
    Setting(u8),
    /// Writes a setting.
    Write(u8, u16),
    /// Commands.
    Control(u8),
    /// Reads a measurement.
    Measured(u8),
    /// Sets the frequency, in 0.01 Hz.
    Frequency(u16),
}

impl Ask {
    /// Returns the number of the function.
    #[must_use]
    pub const fn function(self) -> u8 {
        match self {
            Self::Setting(_) => 1,
            Self::Write(..) => 2,
            Self::Control(_) => 3,
            Self::Measured(_) => 4,
            Self::Frequency(_) => 5,
        }
    }

    /// Returns the frame.
    #[must_use]
    pub fn frame(self, unit: u8) -> Vec<u8> {
        let data = match self {
            Self::Setting(number) => vec![number, 0, 0],
            Self::Write(number, value) => {
                let [high, low] = value.to_be_bytes();
                vec![number, high, low]
            }
            Self::Control(command) => vec![command],
            Self::Measured(number) => vec![number],
            Self::Frequency(value) => value.to_be_bytes().to_vec(),
        };
        frame(unit, self.function(), &data)
    }

    /// Returns the value that the data of an answer have: of a command the state of the inverter, of a write the value that the
    /// setting has now.
    fn read(self, data: &[u8]) -> Option<u16> {
        match (self, data) {
            (Self::Setting(number) | Self::Write(number, _), [which, value])
                if *which == number =>
            {
                Some(u16::from(*value))
            }
            (
                Self::Setting(number) | Self::Write(number, _) | Self::Measured(number),
                [which, high, low],
            ) if *which == number => Some(u16::from_be_bytes([*high, *low])),
            (Self::Control(_), [state]) => Some(u16::from(*state)),
            // The late answer to another frequency is none to this one.
            (Self::Frequency(sent), [high, low]) => {
                Some(u16::from_be_bytes([*high, *low])).filter(|set| *set == sent)
            }
            _ => None,
        }
    }
}

/// Returns a frame with these data.
#[must_use]
pub fn frame(unit: u8, function: u8, data: &[u8]) -> Vec<u8> {
    let mut frame = Vec::new();
    push_frame(&mut frame, unit, function, data);
    frame
}

/// Puts a frame with these data into an empty buffer.
pub fn push_frame(frame: &mut Vec<u8>, unit: u8, function: u8, data: &[u8]) {
    frame.extend([unit, function, u8::try_from(data.len()).unwrap_or(u8::MAX)]);
    frame.extend(data);
    push_crc(frame);
}

/// Takes a whole frame apart: number of the device, function, data.
#[must_use]
pub fn parts(bytes: &[u8]) -> Option<(u8, u8, &[u8])> {
    let [unit, function, length, ..] = *bytes else { return None };
    let end = 3 + usize::from(length);
    let frame = bytes.get(..end + 2).filter(|frame| is_whole(frame))?;
    Some((unit, function, frame.get(3..end)?))
}

/// Finds the answer to a request in the bytes that have come since. Returns its value.
#[must_use]
pub fn find(unit: u8, ask: Ask, bytes: &[u8]) -> Option<u16> {
    (0..bytes.len()).find_map(|at| {
        let (number, function, data) = parts(bytes.get(at..)?)?;
        (number == unit && function == ask.function()).then(|| ask.read(data)).flatten()
    })
}

/// Returns what came instead of an answer.
#[must_use]
pub fn miss(unit: u8, bytes: &[u8]) -> Miss {
    Miss::of(unit, bytes)
}

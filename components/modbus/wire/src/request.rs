//! Requests of a Modbus master.

use crate::{answer::body, push_crc};
use core::fmt;

/// Largest number of bits in a read.
const MAX_READ_BITS: usize = 2000;
/// Largest number of registers in a read.
const MAX_READ_WORDS: usize = 125;
/// Largest number of bits in a write.
const MAX_WRITE_BITS: usize = 1968;
/// Largest number of registers in a write.
const MAX_WRITE_WORDS: usize = 123;

/// Table of a device that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModbusTable {
    /// Outputs of one bit, function 1.
    Coils,
    /// Inputs of one bit, function 2.
    Discretes,
    /// Registers that can be written, function 3.
    Holding,
    /// Registers that can only be read, function 4.
    Inputs,
}

impl ModbusTable {
    const fn function(self) -> u8 {
        match self {
            Self::Coils => 1,
            Self::Discretes => 2,
            Self::Holding => 3,
            Self::Inputs => 4,
        }
    }

    /// Returns whether its elements are single bits.
    #[must_use]
    pub const fn is_bits(self) -> bool {
        matches!(self, Self::Coils | Self::Discretes)
    }
}

/// Question of a master to a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Call {
    /// Reads elements that follow each other.
    Read {
        /// Table that is read.
        table: ModbusTable,
        /// Address of the first element.
        first: u16,
        /// Number of elements.
        count: u16,
    },
    /// Writes one coil, function 5.
    WriteCoil {
        /// Address of the coil.
        at: u16,
        /// Value.
        on: bool,
    },
    /// Writes one register, function 6.
    WriteRegister {
        /// Address of the register.
        at: u16,
        /// Value.
        value: u16,
    },
    /// Writes coils that follow each other, function 15.
    WriteCoils {
        /// Address of the first coil.
        first: u16,
        /// Values.
        on: Vec<bool>,
    },
    /// Writes registers that follow each other, function 16.
    WriteRegisters {
        /// Address of the first register.
        first: u16,
        /// Values.
        values: Vec<u16>,
    },
}

/// Request to one device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModbusRequest {
    /// Number of the device on its line, 1 to 247.
    pub unit: u8,
    /// Question.
    pub call: Call,
}

/// Request that the standard does not allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadRequest {
    /// Number of elements that were asked for.
    pub count: usize,
    /// Largest number.
    pub most: usize,
}

impl fmt::Display for BadRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} elements in one request: 1 to {} are possible", self.count, self.most)
    }
}

impl core::error::Error for BadRequest {}

impl ModbusRequest {
    /// Returns the number of the function.
    #[must_use]
    pub const fn function(&self) -> u8 {
        match &self.call {
            Call::Read { table, .. } => table.function(),
            Call::WriteCoil { .. } => 5,
            Call::WriteRegister { .. } => 6,
            Call::WriteCoils { .. } => 15,
            Call::WriteRegisters { .. } => 16,
        }
    }

    /// Checks the number of elements.
    ///
    /// # Errors
    /// There are none, or more than one frame holds.
    pub fn check(&self) -> Result<(), BadRequest> {
        let (count, most) = match &self.call {
            Call::Read { table, count, .. } => {
                (usize::from(*count), if table.is_bits() { MAX_READ_BITS } else { MAX_READ_WORDS })
            }
            Call::WriteCoil { .. } | Call::WriteRegister { .. } => (1, 1),
            Call::WriteCoils { on, .. } => (on.len(), MAX_WRITE_BITS),
            Call::WriteRegisters { values, .. } => (values.len(), MAX_WRITE_WORDS),
        };
        if (1..=most).contains(&count) { Ok(()) } else { Err(BadRequest { count, most }) }
    }

    /// Returns the number of bytes of its answer on a serial line.
    #[must_use]
    pub fn answer_len(&self) -> usize {
        // The number of the device, the function, and the CRC.
        4 + body(self)
    }

    /// Returns the frame for a serial line.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn rtu(&self) -> Result<Vec<u8>, BadRequest> {
        let mut frame = vec![self.unit];
        self.push(&mut frame)?;
        push_crc(&mut frame);
        Ok(frame)
    }

    /// Returns the frame for TCP. The answer has the number of the transaction.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn tcp(&self, transaction: u16) -> Result<Vec<u8>, BadRequest> {
        let mut body = vec![self.unit];
        self.push(&mut body)?;
        let length = u16::try_from(body.len()).unwrap_or(u16::MAX);
        let mut frame = transaction.to_be_bytes().to_vec();
        frame.extend([0, 0]);
        frame.extend(length.to_be_bytes());
        frame.extend(body);
        Ok(frame)
    }

    /// Appends the function and its data.
    fn push(&self, frame: &mut Vec<u8>) -> Result<(), BadRequest> {
        self.check()?;
        frame.push(self.function());
        match &self.call {
            Call::Read { first, count, .. } => push_words(frame, &[*first, *count]),
            Call::WriteCoil { at, on } => push_words(frame, &[*at, if *on { 0xFF00 } else { 0 }]),
            Call::WriteRegister { at, value } => push_words(frame, &[*at, *value]),
            Call::WriteCoils { first, on } => {
                push_words(frame, &[*first, count(on.len())]);
                let bytes = pack(on);
                frame.push(u8::try_from(bytes.len()).unwrap_or(u8::MAX));
                frame.extend(bytes);
            }
            Call::WriteRegisters { first, values } => {
                push_words(frame, &[*first, count(values.len())]);
                frame.push(u8::try_from(values.len() * 2).unwrap_or(u8::MAX));
                push_words(frame, values);
            }
        }
        Ok(())
    }
}

pub(crate) fn count(n: usize) -> u16 {
    u16::try_from(n).unwrap_or(u16::MAX)
}

fn push_words(frame: &mut Vec<u8>, words: &[u16]) {
    frame.extend(words.iter().flat_map(|word| word.to_be_bytes()));
}

/// Returns bits as bytes, the first in the lowest place.
fn pack(bits: &[bool]) -> Vec<u8> {
    let byte = |bits: &[bool]| {
        bits.iter().enumerate().fold(0_u8, |byte, (n, on)| byte | u8::from(*on) << n)
    };
    bits.chunks(8).map(byte).collect()
}

//! Reasons why the bytes that have come are no answer.

use crate::{ModbusRequest, crc};
use core::fmt;

/// Longest frame on a serial line.
const MAX_FRAME: usize = 256;

/// Shortest frame: shorter ones are found in any noise.
const MIN_FRAME: usize = 5;

/// Bytes that came instead of an answer, by their kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Miss {
    /// Nothing.
    Silent,
    /// The answer of another device, which has this number.
    Other(u8),
    /// A frame of this device with another function, length or address.
    Wrong,
    /// Bytes that are no frame, or a part of one.
    Noise,
}

impl Miss {
    /// Number of kinds.
    pub const KINDS: usize = 4;

    /// Returns what came on a serial line instead of the answer to a request.
    #[must_use]
    pub fn of_rtu(request: &ModbusRequest, bytes: &[u8]) -> Self {
        Self::of(request.unit, bytes)
    }

    /// Returns what came instead of an answer of this device. All frames end with their CRC.
    pub(crate) fn of(unit: u8, bytes: &[u8]) -> Self {
        if bytes.is_empty() {
            return Self::Silent;
        }
        let frame = (0..bytes.len()).find_map(|at| whole(bytes.get(at..)?));
        match frame {
            Some(number) if number == unit => Self::Wrong,
            Some(number) => Self::Other(number),
            None => Self::Noise,
        }
    }

    /// Returns the number of the kind, below [`Self::KINDS`].
    #[must_use]
    pub const fn kind(self) -> usize {
        match self {
            Self::Silent => 0,
            Self::Other(_) => 1,
            Self::Wrong => 2,
            Self::Noise => 3,
        }
    }
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => f.write_str("the device does not answer"),
            Self::Other(unit) => write!(f, "device {unit} has answered instead"),
            Self::Wrong => f.write_str("the device answers something else than was asked"),
            Self::Noise => f.write_str(
                "what comes is no frame: check baud rate, parity, wires and terminators",
            ),
        }
    }
}

/// Returns the number of the device of a frame that begins with the first byte, of any length.
fn whole(bytes: &[u8]) -> Option<u8> {
    let mut sum = crc::START;
    let is_frame = bytes.iter().take(MAX_FRAME).enumerate().any(|(n, byte)| {
        sum = crc::with(sum, *byte);
        MIN_FRAME <= n + 1 && sum == 0
    });
    bytes.first().copied().filter(|_| is_frame)
}

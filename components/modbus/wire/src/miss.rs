//! Reasons why the bytes that have come are no answer.

use crate::{ModbusRequest, is_whole};
use core::fmt;

/// Longest frame on a serial line.
const MAX_FRAME: usize = 256;

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
    /// All kinds, without numbers of devices.
    pub const KINDS: [Self; 4] = [Self::Silent, Self::Other(0), Self::Wrong, Self::Noise];

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

    /// Returns the place among [`Self::KINDS`].
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
    let longest = bytes.len().min(MAX_FRAME);
    let is_frame = |length: usize| bytes.get(..length).is_some_and(is_whole);
    // Shorter ones are found in any noise.
    (5..=longest).rev().find(|length| is_frame(*length)).and_then(|_| bytes.first().copied())
}

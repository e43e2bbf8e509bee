//! Access to devices, shared by real and simulated ones.
//!
//! This is a library for drivers, not a plugin. A driver of registers uses the trait [`Access`]; in simulation,
//! [`Simulated`] implements it with registers whose bits are pins. A driver of lines uses the trait [`Lines`], which
//! [`SimulatedLines`] implements with pins, and [`ReplayedLines`] with the calls that [`RecordedLines`] recorded. A
//! driver of packets uses [`Exchange`]. A [`Shadow`] keeps the value last written to a register, and may be shared by
//! functions in different threads; a [`Report`] reports a device that fails. [`reset_time`] and
//! [`pause`] are for functions that end pulses.
#![forbid(unsafe_code)]

mod exchange;
mod lines;
mod report;
mod reset;
mod shadow;
mod simulated;
mod simulated_lines;
mod tape;

pub use exchange::Exchange;
pub use lines::{LineEdge, Lines};
pub use report::Report;
pub use reset::{pause, reset_time};
pub use shadow::Shadow;
pub use simulated::{Driven, Shown, Simulated};
pub use simulated_lines::{LinePins, SimulatedChip, SimulatedLine, SimulatedLines};
pub use tape::{BadTape, LineCall, RecordedLines, ReplayedLines};

/// Realtime. Registers by address: bytes of I/O space, and the configuration of one PCI device.
pub trait Access: Send + Sync {
    /// Reads the byte at `address`.
    ///
    /// # Errors
    /// The device does not answer.
    fn read(&self, address: u16) -> Result<u8, Lost>;

    /// Writes the byte at `address`, and no other byte.
    ///
    /// # Errors
    /// The device does not answer.
    fn write(&self, address: u16, value: u8) -> Result<(), Lost>;

    /// Reads the double word of PCI configuration that holds `register`.
    ///
    /// # Errors
    /// The device does not answer, or has no such space.
    fn read_config(&self, _register: u8) -> Result<u32, Lost> {
        Err(Lost::NONE)
    }

    /// Writes the double word of PCI configuration that holds `register`.
    ///
    /// # Errors
    /// The device does not answer, or has no such space.
    fn write_config(&self, _register: u8, _value: u32) -> Result<(), Lost> {
        Err(Lost::NONE)
    }
}

/// Error of a device that does not answer, with the system's error number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost(pub i32);

impl Lost {
    /// Error for a register space that does not exist (ENXIO).
    pub const NONE: Self = Self(6);
    /// Error of a device that is gone (ENODEV).
    pub const GONE: Self = Self(19);
}

impl core::fmt::Display for Lost {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "the device does not answer ({})", std::io::Error::from_raw_os_error(self.0))
    }
}

impl core::error::Error for Lost {}

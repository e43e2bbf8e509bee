//! Access to device registers: what real and simulated ports have in common.
//!
//! A library for port drivers, not a plugin. A driver works through [`Access`]; in simulation that
//! is [`Simulated`], a register file whose bits are pins. What a driver wrote last is kept in a
//! [`Shadow`], which functions in different threads may share; that a device fails is said by a
//! [`Report`].
#![forbid(unsafe_code)]

mod report;
mod shadow;
mod simulated;

pub use report::Report;
pub use shadow::Shadow;
pub use simulated::{Driven, Shown, Simulated};

/// Realtime. Registers by address: bytes of I/O space, and the configuration of one PCI device.
pub trait Access: Send + Sync {
    /// The byte at `address`.
    ///
    /// # Errors
    /// The device does not answer.
    fn read(&self, address: u16) -> Result<u8, Lost>;

    /// Writes the byte at `address`, and no other.
    ///
    /// # Errors
    /// The device does not answer.
    fn write(&self, address: u16, value: u8) -> Result<(), Lost>;

    /// The double word of PCI configuration that holds `register`.
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

/// A device that does not answer, with the system's error number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost(pub i32);

impl Lost {
    /// There is no such register space (ENXIO).
    pub const NONE: Self = Self(6);
}

impl core::fmt::Display for Lost {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "the device does not answer ({})", std::io::Error::from_raw_os_error(self.0))
    }
}

impl core::error::Error for Lost {}

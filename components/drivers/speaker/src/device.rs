//! Realtime. Open register, real or simulated.

use crate::REGISTER;
use hal_component::{Builder, Error};
use port::{Access, Lost, Simulated};
use std::{
    fs::{File, OpenOptions},
    os::unix::fs::FileExt,
    sync::OnceLock,
};

/// Device file of the processor's I/O ports, one byte each.
const PORTS: &str = "/dev/port";

/// Access to the register.
#[derive(Debug)]
pub(crate) enum Device {
    Simulated(Simulated),
    /// Empty until the register is opened.
    Real(OnceLock<File>),
}

impl Device {
    pub(crate) fn new(b: &mut Builder<'_>) -> Result<Self, Error> {
        if !b.is_simulated() {
            return Ok(Self::Real(OnceLock::new()));
        }
        let mut file = Simulated::new(b, "speaker.sim", REGISTER, 1)?;
        file.show(b, "0061", 0, 0, 0)?;
        file.drive(b, "0061-in", 0, 0)?;
        Ok(Self::Simulated(file))
    }

    pub(crate) const fn simulated(&self) -> Option<&Simulated> {
        match self {
            Self::Simulated(file) => Some(file),
            Self::Real(_) => None,
        }
    }

    /// Opens the real register.
    pub(crate) fn open(&self) -> Result<(), Closed> {
        if let Self::Real(slot) = self {
            let ports = OpenOptions::new().read(true).write(true).open(PORTS).map_err(Closed)?;
            // A second opening keeps the first.
            drop(slot.set(ports));
        }
        Ok(())
    }
}

/// Error of a register that cannot be opened.
#[derive(Debug)]
pub(crate) struct Closed(pub(crate) std::io::Error);

impl core::fmt::Display for Closed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self(why) = self;
        let who = if why.kind() == std::io::ErrorKind::PermissionDenied {
            ": only root opens it"
        } else {
            ""
        };
        write!(f, "{PORTS}: {why}{who}; or run with --simulate")
    }
}

impl core::error::Error for Closed {}

impl Access for Device {
    fn read(&self, address: u16) -> Result<u8, Lost> {
        match self {
            Self::Simulated(file) => file.read(address),
            Self::Real(slot) => {
                let mut byte = [0];
                let file = slot.get().ok_or(Lost::NONE)?;
                file.read_exact_at(&mut byte, u64::from(address)).map_err(|e| lost(&e))?;
                Ok(byte[0])
            }
        }
    }

    fn write(&self, address: u16, value: u8) -> Result<(), Lost> {
        match self {
            Self::Simulated(file) => file.write(address, value),
            Self::Real(slot) => {
                let file = slot.get().ok_or(Lost::NONE)?;
                file.write_all_at(&[value], u64::from(address)).map_err(|e| lost(&e))
            }
        }
    }
}

fn lost(error: &std::io::Error) -> Lost {
    error.raw_os_error().map_or(Lost::NONE, Lost)
}

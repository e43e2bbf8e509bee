//! Realtime. Open chip, real or simulated.

use crate::{
    chip::{self, Chip, Refused},
    hardware::Hardware,
};
use core::sync::atomic::{
    AtomicU32,
    Ordering::{Acquire, Release},
};
use hal_component::{Builder, Error};
use port::{Access, Lost, Simulated};
use std::{path::Path, sync::OnceLock};

/// Chip behind the connector.
#[derive(Debug)]
pub(crate) struct Device {
    access: Kind,
    /// Empty until the chip is opened.
    chip: OnceLock<Chip>,
    /// Levels in the output registers with all pins FALSE, one byte each.
    idle: AtomicU32,
}

/// Value of `idle` before the first write.
const NO_IDLE: u32 = u32::MAX;

#[derive(Debug)]
enum Kind {
    Simulated(Simulated),
    /// Empty until the chip is opened.
    Real(OnceLock<Hardware>),
}

impl Device {
    pub(crate) fn new(b: &mut Builder<'_>) -> Result<Self, Error> {
        let access = if b.is_simulated() {
            Kind::Simulated(simulated(b)?)
        } else {
            Kind::Real(OnceLock::new())
        };
        Ok(Self { access, chip: OnceLock::new(), idle: AtomicU32::new(NO_IDLE) })
    }

    pub(crate) const fn simulated(&self) -> Option<&Simulated> {
        match &self.access {
            Kind::Simulated(file) => Some(file),
            Kind::Real(_) => None,
        }
    }

    /// Opens the chip; `config` is the path of the PCI device's configuration.
    pub(crate) fn open(&self, config: &Path) -> Result<(), Refused> {
        if let Kind::Real(slot) = &self.access {
            // A second opening keeps the first.
            drop(slot.set(Hardware::open(config)?));
        }
        let access = self.access().ok_or(Lost::NONE)?;
        drop(self.chip.set(Chip::bring_up(access)?));
        Ok(())
    }

    fn access(&self) -> Option<&dyn Access> {
        match &self.access {
            Kind::Simulated(file) => Some(file),
            Kind::Real(slot) => slot.get().map(|h| h as &dyn Access),
        }
    }

    fn open_chip(&self) -> Result<(&Chip, &dyn Access), Lost> {
        self.chip.get().zip(self.access()).ok_or(Lost::NONE)
    }

    /// Reads the input registers.
    pub(crate) fn read(&self) -> Result<[u8; 2], Lost> {
        let (chip, access) = self.open_chip()?;
        chip.read(access)
    }

    /// Writes the levels of the lines, and stores their idle levels.
    pub(crate) fn write(&self, levels: [u8; 3], [a, b, c]: [u8; 3]) -> Result<(), Lost> {
        self.idle.store(u32::from_le_bytes([a, b, c, 0]), Release); // Pairs with `drop`.
        let (chip, access) = self.open_chip()?;
        chip.write(access, levels)
    }
}

impl Drop for Device {
    /// Drives the outputs of a real chip to their idle levels, if the chip was ever written to.
    fn drop(&mut self) {
        let idle = self.idle.load(Acquire); // Pairs with `write`.
        if idle == NO_IDLE || self.simulated().is_some() {
            return;
        }
        let [a, b, c, _] = idle.to_le_bytes();
        // A lost device can no longer be reported.
        let _ = self.write([a, b, c], [a, b, c]);
    }
}

/// Address of the registers in simulation; the low bit of the register is a flag.
const SIMULATED_BASE: u16 = 0x0400;
const SIMULATED_BASE_REGISTER: u32 = 0x0401;

/// Simulates a board as its firmware leaves it: no output enabled, all lines low, and every other bit 1, so that a
/// write to a neighbouring bit becomes visible.
pub(crate) fn simulated(b: &mut Builder<'_>) -> Result<Simulated, Error> {
    let mut file = Simulated::new(b, "viagpio.sim", SIMULATED_BASE, 0x100)?;
    for (register, lines) in chip::INPUTS.into_iter().zip([0x30, 0x03]) {
        file.drive(b, &format!("reg-{register:02x}"), register, lines)?;
    }
    for (register, lines) in chip::OUTPUTS.into_iter().zip(chip::LINES) {
        file.show(b, &format!("reg-{register:02x}"), register, lines, !lines)?;
    }
    for register in [0x4C, 0x50, 0x51, 0x52] {
        file.show(b, &format!("reg-{register:02x}"), register, 0, 0xFF)?;
    }
    for (register, reset) in [
        (0, chip::IDENTITY),
        (chip::BASE, SIMULATED_BASE_REGISTER),
        (chip::RX80, 0xFFFF_FFFF),
        (chip::RX95, 0),
        (chip::RX9B, 0),
    ] {
        file.config(b, register, reset)?;
    }
    Ok(file)
}

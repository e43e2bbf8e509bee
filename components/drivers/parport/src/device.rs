//! Realtime. Port with its registers, real or simulated, and the values last written to them.

use crate::{
    config::{PortConfig, PortLocation},
    hardware::{Hardware, System},
    lines::{self, Output},
};
use core::sync::atomic::{
    AtomicI64, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};
use hal_component::{Builder, Clock, Error};
use port::{Access, Lost, Shadow, Simulated};
use std::sync::OnceLock;

/// Registers, by their offset from the port's address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub(crate) enum Register {
    /// Eight output or input lines.
    Data = 0,
    /// Five input lines.
    Status = 1,
    /// Four output or input lines, and the direction of the data lines.
    Control = 2,
}

impl Register {
    /// Returns the bits that are high on the connector when they are 0.
    const fn inverted(self) -> u8 {
        match self {
            Self::Data => 0,
            Self::Status => 0x80,
            Self::Control => 0x0B,
        }
    }
}

/// Bit of the control register that makes the data lines inputs.
const DATA_IN: u8 = 0x20;

/// Parallel port.
#[derive(Debug)]
pub(crate) struct Device {
    config: PortConfig,
    access: Kind,
    /// Data levels, and control levels shifted by eight, with all pins FALSE.
    idle: AtomicU32,
}

/// Value of `idle` before the first write.
const NO_IDLE: u32 = u32::MAX;

#[derive(Debug)]
enum Kind {
    Simulated {
        base: u16,
        file: Simulated,
    },
    /// Empty until the port is opened.
    Real(OnceLock<Hardware>),
}

/// Values last written to the registers of a port, with their times.
#[derive(Debug, Default)]
pub(crate) struct Written {
    data: LastWrite,
    control: LastWrite,
}

#[derive(Debug, Default)]
struct LastWrite {
    levels: Shadow,
    time: AtomicI64,
}

impl Device {
    pub(crate) fn new(
        b: &mut Builder<'_>,
        index: usize,
        config: PortConfig,
    ) -> Result<Self, Error> {
        let access = if b.is_simulated() {
            let base = match config.place {
                PortLocation::Address(address) => address,
                PortLocation::Kernel(_) => 0x378,
            };
            Kind::Simulated { base, file: simulated(b, index, base, config)? }
        } else {
            Kind::Real(OnceLock::new())
        };
        Ok(Self { config, access, idle: AtomicU32::new(NO_IDLE) })
    }

    pub(crate) const fn simulated(&self) -> Option<&Simulated> {
        match &self.access {
            Kind::Simulated { file, .. } => Some(file),
            Kind::Real(_) => None,
        }
    }

    /// Opens the registers, and turns the lines that are read into inputs.
    pub(crate) fn open(&self, index: usize, system: &System) -> Result<(), Error> {
        let failed = |why: &dyn core::fmt::Display| Error::new(format!("parport.{index}: {why}"));
        if let Kind::Real(slot) = &self.access {
            let hardware =
                Hardware::open(system, index, self.config).map_err(|why| failed(&why))?;
            // A second opening keeps the first.
            drop(slot.set(hardware));
        }
        if self.config.mode.reads_data() || self.config.mode.reads_control() {
            self.write(Register::Control, self.control(0)).map_err(|why| failed(&why))?;
        }
        Ok(())
    }

    fn access(&self) -> Option<(u16, &dyn Access)> {
        match &self.access {
            Kind::Simulated { base, file } => Some((*base, file)),
            Kind::Real(slot) => slot.get().map(|h| (h.base(), h as &dyn Access)),
        }
    }

    /// Returns the levels of the lines of a register.
    pub(crate) fn read(&self, register: Register) -> Result<u8, Lost> {
        let (base, access) = self.access().ok_or(Lost::NONE)?;
        Ok(access.read(base.wrapping_add(register as u16))? ^ register.inverted())
    }

    /// Writes the levels of the lines of a register.
    pub(crate) fn write(&self, register: Register, levels: u8) -> Result<(), Lost> {
        let (base, access) = self.access().ok_or(Lost::NONE)?;
        access.write(base.wrapping_add(register as u16), levels ^ register.inverted())
    }

    /// Returns the control levels with the bits that the mode requires: input lines are released to high, and the data
    /// lines get their direction.
    pub(crate) fn control(&self, levels: u8) -> u8 {
        let levels = if self.config.mode.reads_control() { 0x0F } else { levels };
        if self.config.mode.reads_data() { levels | DATA_IN } else { levels }
    }

    /// Stores the idle levels, which are written when the port is dropped.
    pub(crate) fn note_idle(&self, data: u8, control: u8) {
        // Pairs with `rest`.
        self.idle.store(u32::from(u16::from_le_bytes([data, control])), Release);
    }

    /// Drives every output to its level for FALSE.
    pub(crate) fn rest(&self, data: u8, control: u8) -> Result<(), Lost> {
        let data =
            if self.config.mode.reads_data() { Ok(()) } else { self.write(Register::Data, data) };
        data.and(self.write(Register::Control, self.control(control)))
    }
}

impl Drop for Device {
    /// Drives the outputs of a real port to their idle levels, if the port was ever written to.
    fn drop(&mut self) {
        let idle = self.idle.load(Acquire); // Pairs with `note_idle`.
        if idle == NO_IDLE || self.simulated().is_some() {
            return;
        }
        let [data, control, ..] = idle.to_le_bytes();
        // A lost device can no longer be reported.
        let _ = self.rest(data, control);
    }
}

impl Written {
    fn of(&self, register: Register) -> &LastWrite {
        if register == Register::Data { &self.data } else { &self.control }
    }

    /// Writes the levels if the register may hold others.
    pub(crate) fn put(
        &self,
        device: &Device,
        clock: Clock,
        register: Register,
        levels: u8,
    ) -> Result<(), Lost> {
        let last = self.of(register);
        let write = |levels| {
            device.write(register, levels)?;
            last.time.store(clock.now_ns(), Relaxed); // Published by the shadow.
            Ok(())
        };
        last.levels.put(levels, write).map(|_| ())
    }

    /// Returns the levels in a register, and the time of their write in nanoseconds.
    pub(crate) fn last(&self, register: Register) -> Option<(u8, i64)> {
        let last = self.of(register);
        Some((last.levels.last()?, last.time.load(Relaxed)))
    }

    /// Makes the next write take place even if its levels are the same.
    pub(crate) fn forget(&self) {
        self.data.levels.forget();
        self.control.levels.forget();
    }
}

/// Stop action: drives the outputs to their idle levels, and makes the next writes unconditional.
pub(crate) fn stop(device: &Device, written: &Written, data: &[Output], control: &[Output]) {
    let ((_, data), (_, control)) = (lines::levels(data), lines::levels(control));
    // A lost device cannot be stopped; the write function reports it.
    let _ = device.rest(data, control);
    written.forget();
}

fn simulated(
    b: &mut Builder<'_>,
    index: usize,
    base: u16,
    config: PortConfig,
) -> Result<Simulated, Error> {
    let mut file = Simulated::new(b, &format!("parport.{index}.sim"), base, 3)?;
    let mode = config.mode;
    if mode.reads_data() {
        file.drive(b, "data", Register::Data as u16, 0xFF)?;
    } else {
        file.show(b, "data", Register::Data as u16, 0xFF, 0)?;
    }
    file.drive(b, "status", Register::Status as u16, 0xF8)?;
    let outputs = if mode.reads_control() { DATA_IN } else { DATA_IN | 0x0F };
    file.show(b, "control", Register::Control as u16, outputs, 0)?;
    if mode.reads_control() {
        file.drive_bits(b, "control", Register::Control as u16, 0x0F)?;
    }
    Ok(file)
}

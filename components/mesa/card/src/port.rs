//! Ports of I/O pins.
//!
//! Source: Mesa's `wordpr.vhd`, published under the BSD licence with 3 clauses.

use hal_firmware::registers as r;

// Numbers of registers.
const DIRECTION: u8 = r::PORT_DIRECTION.index;
const DATA: u8 = r::PORT_DATA.index;
const SOURCE: u8 = r::PORT_SOURCE.index;
const OPEN_DRAIN: u8 = r::PORT_OPEN_DRAIN.index;
const INVERT: u8 = r::PORT_INVERT.index;

/// Port of at most 32 pins.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Port {
    data: u32,
    direction: u32,
    source: u32,
    open_drain: u32,
    invert: u32,
}

/// Driver of an I/O pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drive {
    /// Nothing: the pin is an input, or an open drain that is high.
    Released,
    /// A level.
    Level(bool),
}

impl Port {
    /// Returns whether the pin is an output that its module drives.
    pub(crate) const fn is_modules(&self, bit: u32) -> bool {
        self.direction & self.source & (1 << bit) != 0
    }

    /// Returns what the port does with a pin whose module has this level.
    pub(crate) const fn drive(&self, bit: u32, module: bool) -> Drive {
        let mask = 1 << bit;
        if self.direction & mask == 0 {
            return Drive::Released;
        }
        let level = if self.source & mask != 0 { module } else { self.data & mask != 0 };
        let level = level != (self.invert & mask != 0);
        if level && self.open_drain & mask != 0 { Drive::Released } else { Drive::Level(level) }
    }

    /// Makes all pins inputs, as the watchdog does.
    pub(crate) const fn clear(&mut self) {
        (self.direction, self.open_drain) = (0, 0);
    }

    /// Returns a register other than the levels of the pins.
    pub(crate) const fn read(&self, register: u8) -> u32 {
        match register {
            DIRECTION => self.direction,
            _ => 0,
        }
    }

    pub(crate) const fn write(&mut self, register: u8, value: u32) {
        match register {
            DATA => self.data = value,
            DIRECTION => self.direction = value,
            SOURCE => self.source = value,
            OPEN_DRAIN => self.open_drain = value,
            INVERT => self.invert = value,
            _ => {}
        }
    }
}

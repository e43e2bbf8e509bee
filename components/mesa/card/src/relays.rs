//! Solid-state relays, plain outputs, and lights: registers whose bits are levels.
//!
//! Source: Mesa's `xfrmrout.vhd` and `outm.vhd`, published under the BSD licence with 3 clauses.

use hal_firmware::registers as r;

// Numbers of registers.
const DATA: u8 = r::SSR_DATA.index;
const RATE: u8 = r::SSR_RATE.index;

/// Relays of a module, whose drivers are fed through transformers by a square wave.
#[derive(Debug, Default)]
pub(crate) struct Relays {
    data: u32,
    rate: u32,
    clock: u64,
}

/// Number of the pin that has the wave.
const REFERENCE: u8 = 0x20;
const ENABLE: u32 = 1 << 12;

impl Relays {
    pub(crate) const fn advance(&mut self, clock: u64) {
        self.clock = self.clock.wrapping_add(clock);
    }

    const fn wave(&self) -> bool {
        let half = (self.rate & 0x0FFF) as u64 + 2;
        self.rate & ENABLE != 0 && (self.clock / half) & 1 == 1
    }

    /// Returns whether a relay is closed.
    pub(crate) const fn is_on(&self, relay: u8) -> bool {
        self.rate & ENABLE != 0 && relay < 32 && self.data >> relay & 1 == 1
    }

    pub(crate) fn level(&self, number: u8) -> bool {
        let bit = number.wrapping_sub(1);
        if number == REFERENCE {
            self.wave()
        } else {
            self.wave() != (bit < 32 && self.data >> bit & 1 == 1)
        }
    }

    pub(crate) const fn read(&self, register: u8) -> u32 {
        match register {
            DATA => self.data,
            RATE => self.rate & 0x1FFF,
            _ => 0,
        }
    }

    pub(crate) const fn write(&mut self, register: u8, value: u32) {
        match register {
            DATA => self.data = value,
            RATE => self.rate = value,
            _ => {}
        }
    }
}

//! Watchdog.
//!
//! A counter runs down; when its bit 31 becomes 1, the watchdog bites. Written with bit 31, the counter stands still.
//! Source: Mesa's `watchdog.vhd`, published under the BSD licence with 3 clauses.

use hal_firmware::registers as r;

// Numbers of registers.
const TIMEOUT: u8 = r::WATCHDOG_TIMEOUT.index;
const STATUS: u8 = r::WATCHDOG_STATUS.index;
const RESET: u8 = r::WATCHDOG_RESET.index;

const OFF: u32 = 0x8000_0000;
/// First byte of what is written to let the time begin again.
const COOKIE: u8 = 0x5A;

/// Watchdog of a card.
#[derive(Debug)]
pub(crate) struct Watchdog {
    timer: u32,
    time: u32,
    has_bitten: bool,
}

impl Watchdog {
    pub(crate) const fn new() -> Self {
        Self { timer: OFF, time: OFF, has_bitten: false }
    }

    pub(crate) const fn has_bitten(&self) -> bool {
        self.has_bitten
    }

    /// Returns the clock periods until it bites, if it runs.
    pub(crate) const fn until_bite(&self) -> Option<u64> {
        if self.timer & OFF == 0 { Some(self.timer as u64 + 1) } else { None }
    }

    pub(crate) fn advance(&mut self, clock: u64) {
        let Some(left) = self.until_bite() else { return };
        if clock < left {
            self.timer = u32::try_from(left - clock - 1).unwrap_or(0);
        } else {
            (self.timer, self.has_bitten) = (u32::MAX, true);
        }
    }

    pub(crate) fn read(&self, register: u8) -> u32 {
        match register {
            TIMEOUT => self.timer,
            STATUS => u32::from(self.has_bitten),
            _ => 0,
        }
    }

    pub(crate) fn write(&mut self, register: u8, value: u32) {
        match register {
            TIMEOUT => {
                self.time = value;
                self.load(value);
            }
            STATUS => self.has_bitten = value & 1 == 1,
            RESET => {
                let [.., cookie] = value.to_le_bytes();
                if cookie == COOKIE {
                    self.load(self.time);
                }
            }
            _ => {}
        }
    }

    /// Loads the counter. A running one that is loaded with bit 31 bites, as if it had run down.
    fn load(&mut self, value: u32) {
        self.has_bitten |= self.timer & OFF == 0 && value & OFF != 0;
        self.timer = value;
    }
}

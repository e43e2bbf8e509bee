//! Time: the timer that latches a module's values, clocks in periods, time stamps.

/// Timer of the clock that latches the values of a module, as its register has it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Latched(u32);

impl Latched {
    pub(crate) const fn from_register(value: u32) -> Self {
        Self(value & 0xF000)
    }

    pub(crate) const fn register(self) -> u32 {
        self.0
    }

    pub(crate) const fn is_enabled(self) -> bool {
        self.0 & 0x8000 != 0
    }

    /// Returns the timers that latch: bit 0 is the clock's reference, bits 1 to 4 are its timers.
    pub(crate) const fn timers(self) -> u8 {
        let timer = (self.0 >> 12) & 7;
        match (self.is_enabled(), timer) {
            (false, _) => 0,
            (true, 1) => 2,
            (true, 2) => 4,
            (true, 3) => 8,
            (true, 4) => 16,
            _ => 1,
        }
    }

    pub(crate) const fn takes(self, events: u8) -> bool {
        self.timers() & events != 0
    }
}

/// Clock whose periods are counted from nanoseconds, without a loss.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ticks {
    hz: u64,
    rest: u64,
}

const SECOND: u64 = 1_000_000_000;

impl Ticks {
    pub(crate) const fn new(hz: u32) -> Self {
        Self { hz: hz as u64, rest: 0 }
    }

    /// Returns the periods of a time of at most a second.
    pub(crate) const fn take(&mut self, ns: u64) -> u64 {
        let sum = self.rest + ns * self.hz;
        self.rest = sum % SECOND;
        sum / SECOND
    }
}

/// Counter of time stamps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stamps {
    pub(crate) counter: u16,
    pub(crate) rest: u64,
    pub(crate) divisor: u32,
}

impl Stamps {
    /// Returns the stamp after a time.
    pub(crate) fn after(&self, clock: u64) -> u16 {
        let [low, high, ..] = ((self.rest + clock) / self.period()).to_le_bytes();
        self.counter.wrapping_add(u16::from_le_bytes([low, high]))
    }

    const fn period(&self) -> u64 {
        (self.divisor & 0x7FFF) as u64 + 2
    }

    pub(crate) fn advance(&mut self, clock: u64) {
        self.counter = self.after(clock);
        self.rest = (self.rest + clock) % self.period();
    }
}

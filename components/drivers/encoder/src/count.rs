//! Realtime. Counting: the fast function of `encoder`.

use crate::{
    encoder::Pins,
    handover::{Notes, TimeBase},
};
use hal_component::{Gives, In, Io, Out, Period, Touch, Update};
use std::sync::atomic::Ordering::{Acquire, Release};

const UP: u8 = 0x40;
const DOWN: u8 = 0x80;

/// Transition table. The index holds the previous A (4) and B (8) and the present A (1) and B (2); an entry holds the
/// next previous phases and the count direction.
const EVERY_EDGE: [u8; 16] = [
    0x00, 0x44, 0x88, 0x0c, 0x80, 0x04, 0x08, 0x4c, 0x40, 0x04, 0x08, 0x8c, 0x00, 0x84, 0x48, 0x0c,
];
/// Table with one count per quadrature cycle.
const ONE_EDGE: [u8; 16] = [
    0x00, 0x44, 0x08, 0x0c, 0x80, 0x04, 0x08, 0x0c, 0x00, 0x04, 0x08, 0x0c, 0x00, 0x04, 0x08, 0x0c,
];
/// Table for the rising edges of A only; B counts as false, and bit 8 says that A was true.
const PULSES: [u8; 16] = [0, 0x48, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0];

/// State of one channel in the fast function.
#[derive(Touch)]
pub(crate) struct Channel {
    pub(crate) phase_a: In<bool>,
    pub(crate) phase_b: In<bool>,
    pub(crate) phase_z: In<bool>,
    pub(crate) latch_input: In<bool>,
    pub(crate) latch_rising: In<bool>,
    pub(crate) latch_falling: In<bool>,
    pub(crate) x4_mode: Io<bool>,
    pub(crate) counter_mode: Io<bool>,
    pub(crate) missing_teeth: In<i32>,
    pub(crate) rawcounts: Out<i32>,
    pub(crate) notes: Gives<Notes>,
    #[state]
    state: u8,
    #[state]
    raw: i32,
    /// Time of the last upward count, in nanoseconds of the time base.
    #[state]
    up_at: u32,
    #[state]
    z_was: bool,
    #[state]
    latch_was: bool,
}

impl Channel {
    pub(crate) fn new(pins: &Pins, notes: Gives<Notes>) -> Self {
        Self {
            phase_a: pins.phase_a,
            phase_b: pins.phase_b,
            phase_z: pins.phase_z,
            latch_input: pins.latch_input,
            latch_rising: pins.latch_rising,
            latch_falling: pins.latch_falling,
            x4_mode: pins.x4_mode,
            counter_mode: pins.counter_mode,
            missing_teeth: pins.missing_teeth,
            rawcounts: pins.rawcounts,
            notes,
            state: 0,
            raw: 0,
            up_at: 0,
            z_was: false,
            latch_was: false,
        }
    }

    /// Counts the change of the phases. Returns whether there was a count.
    fn count(&mut self) -> bool {
        let mut at = self.state & 0x0c | u8::from(self.phase_a.get());
        let table = if self.counter_mode.get() {
            &PULSES
        } else {
            at |= u8::from(self.phase_b.get()) << 1;
            if self.x4_mode.get() { &EVERY_EDGE } else { &ONE_EDGE }
        };
        self.state = table.get(usize::from(at)).copied().unwrap_or(0);
        if self.state & UP != 0 {
            self.raw = self.raw.wrapping_add(1);
        } else if self.state & DOWN != 0 {
            self.raw = self.raw.wrapping_sub(1);
        }
        self.state & (UP | DOWN) != 0
    }

    fn run(&mut self, now: u32) {
        let counted = self.count();
        let missing = self.missing_teeth.get();
        let pause = self.notes.pause.load(Acquire); // Pairs with the capture.
        let gap = self.state & UP != 0
            && missing != 0
            && now.wrapping_sub(self.up_at).cast_signed() >= pause;
        if gap {
            self.raw = self.raw.wrapping_add(missing);
        }
        let seen = self.notes.write();
        if counted {
            if self.state & UP != 0 {
                self.up_at = now;
            }
            seen.raw.store(self.raw, Release); // Pairs with the capture.
            seen.at.store(now, Release); // Pairs with the capture.
            seen.counted.store(true, Release); // Pairs with the capture.
        }
        // The index pulse is at the missing teeth as well.
        let z = gap || self.phase_z.get();
        let armed = self.notes.armed.load(Acquire); // Pairs with the capture.
        if armed && z && !self.z_was {
            seen.index.store(self.raw, Release); // Pairs with the capture.
            seen.indexed.store(true, Release); // Pairs with the capture.
            self.notes.armed.store(false, Release); // Pairs with the capture.
        }
        self.z_was = z;
        let latch = self.latch_input.get();
        if latch != self.latch_was {
            let wanted = if latch { &self.latch_rising } else { &self.latch_falling };
            if wanted.get() {
                seen.latch.store(self.raw, Release); // Pairs with the capture.
                seen.latched.store(true, Release); // Pairs with the capture.
            }
        }
        self.latch_was = latch;
        self.rawcounts.set(self.raw);
    }
}

/// `encoder.update-counters`.
#[derive(Touch)]
pub(crate) struct UpdateCounters {
    pub(crate) channels: Vec<Channel>,
    pub(crate) time: Gives<TimeBase>,
}

impl Update for UpdateCounters {
    fn update(&mut self, period: Period) {
        let now = self.time.now();
        for c in &mut self.channels {
            c.run(now);
        }
        #[expect(clippy::cast_possible_truncation, reason = "the time wraps")]
        let passed = period.ns().cast_unsigned() as u32;
        self.time.set(now.wrapping_add(passed));
    }
}

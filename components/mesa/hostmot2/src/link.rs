//! Realtime. The way to a card: packets of a cycle, their sequence numbers, and whether they arrived.

use crate::plan::{MAX_WRITES, NUMBER_AT, ReadAnswer, SCRATCH};
use core::{
    sync::atomic::{
        AtomicBool, AtomicU16, AtomicU32,
        Ordering::{Acquire, Relaxed, Release},
    },
    time::Duration,
};
use hal_component::Clock;
use hal_lbp16::{MAX_ITEMS, Packet, Space};
use port::{Exchange, Lost};
use std::sync::Arc;

/// Way to one card, which the functions of the card share.
pub(crate) struct Link {
    device: Box<dyn Exchange>,
    clock: Clock,
    question: Question,
    /// Sequence number of the last question; 0 before the first.
    asked: AtomicU16,
    /// True from a question until its answer was taken or abandoned.
    waits: AtomicBool,
    /// Machine time at which the last question was sent, low half.
    asked_at: AtomicU32,
    /// Sequence number of the packets of the last cycle that wrote, and how many there were.
    wrote: AtomicU16,
    packets: AtomicU16,
    renewals: Renewals,
}

/// Number of times that everything had to be written again: at first, after a lost packet, after the watchdog.
#[derive(Clone, Debug)]
pub(crate) struct Renewals(Arc<AtomicU32>);

impl Renewals {
    pub(crate) fn new() -> Self {
        Self(Arc::new(AtomicU32::new(1)))
    }

    /// Lets everything be written again in the next cycle.
    pub(crate) fn renew(&self) {
        self.0.fetch_add(1, Release); // Pairs with Acquire in `now`.
    }

    fn now(&self) -> u32 {
        self.0.load(Acquire) // Pairs with Release in `renew`.
    }
}

impl core::fmt::Debug for Link {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Link").finish_non_exhaustive()
    }
}

/// Packet that asks, with the place and the value of the address that the raw pins set.
pub(crate) struct Question {
    pub(crate) packet: Packet,
    pub(crate) raw: Option<usize>,
    pub(crate) address: Arc<AtomicU16>,
}

/// Times of a question in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Times {
    /// From the question to its answer.
    pub(crate) round_trip: u32,
    /// Of this, time in which the thread waited.
    pub(crate) waited: u32,
}

/// Result of a question.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outcome<'a> {
    /// The answer came. `written` is true if the card had received all that the last cycle wrote.
    Answered { answer: ReadAnswer<'a>, written: bool, times: Times },
    /// No answer came in time.
    Late,
    /// The way to the card failed.
    Lost(Lost),
}

impl Link {
    pub(crate) fn new(
        device: Box<dyn Exchange>,
        clock: Clock,
        question: Question,
        renewals: Renewals,
    ) -> Self {
        Self {
            device,
            clock,
            question,
            asked: AtomicU16::new(0),
            waits: AtomicBool::new(false),
            asked_at: AtomicU32::new(0),
            wrote: AtomicU16::new(0),
            packets: AtomicU16::new(0),
            renewals,
        }
    }

    /// Passes a cycle without a question: forgets one under way, and lets the time of a simulated card pass.
    pub(crate) fn pass(&self) {
        self.waits.store(false, Release); // Pairs with Acquire in `ask`.
        self.device.advance(self.clock.now_ns());
    }

    /// Sends the question of this cycle, unless one is under way.
    pub(crate) fn ask(&self) -> Result<(), Lost> {
        if self.waits.load(Acquire) {
            return Ok(());
        }
        self.device.advance(self.clock.now_ns());
        let number = after(self.asked.load(Relaxed));
        let mut packet = self.question.packet;
        packet.patch(NUMBER_AT, number);
        if let Some(at) = self.question.raw {
            packet.patch(at, self.question.address.load(Relaxed));
        }
        self.asked.store(number, Relaxed); // Published with `waits`.
        self.asked_at.store(low(self.clock.now_ns()), Relaxed); // Published with `waits`.
        self.device.send(packet.bytes())?;
        self.waits.store(true, Release); // Pairs with Acquire in `answer` and `ask`.
        Ok(())
    }

    /// Takes the answer of this cycle; sends the question before that if nobody has. Answers to earlier questions, and
    /// packets that are none, are discarded.
    pub(crate) fn answer<'a>(&self, into: &'a mut [u8], within: Duration) -> Outcome<'a> {
        if let Err(lost) = self.ask() {
            return Outcome::Lost(lost);
        }
        self.waits.store(false, Release); // Pairs with Acquire in `ask`.
        let (number, asked_at) = (self.asked.load(Relaxed), self.asked_at.load(Relaxed));
        let begin = self.clock.now_ns();
        let expected = self.question.packet.answer_bytes();
        let most = i64::try_from(within.as_nanos()).unwrap_or(i64::MAX);
        // A flood of strange packets must not hold the thread: each reading of the clock takes time, and on the virtual
        // clock, where it takes none, the number of packets is bounded.
        for _ in 0..MAX_STRANGE {
            let passed = self.clock.now_ns().wrapping_sub(begin);
            let Ok(rest) = u64::try_from(most.saturating_sub(passed)) else { break };
            let length = match self.device.receive(into, Duration::from_nanos(rest)) {
                Ok(0) => break,
                Ok(length) => length,
                Err(lost) => return Outcome::Lost(lost),
            };
            let numbers = into.get(..length).and_then(|bytes| ReadAnswer(bytes).numbers());
            let Some((question, writes)) = numbers.filter(|_| length == expected) else { continue };
            if question != number {
                continue;
            }
            let now = self.clock.now_ns();
            let times = Times {
                round_trip: low(now).wrapping_sub(asked_at),
                waited: low(now).wrapping_sub(low(begin)),
            };
            let wrote = self.wrote.load(Relaxed);
            let packets = usize::from(self.packets.load(Relaxed));
            let written = writes.iter().take(packets).all(|got| *got == wrote);
            return Outcome::Answered {
                answer: ReadAnswer(into.get(..length).unwrap_or_default()),
                written,
                times,
            };
        }
        Outcome::Late
    }

    /// Begins the packets of a cycle that writes.
    pub(crate) fn begin(&self) -> Outgoing<'_> {
        let number = after(self.wrote.load(Relaxed));
        Outgoing {
            link: self,
            packet: Packet::new(),
            number,
            packets: 0,
            lost: Ok(()),
            run: [0; MAX_ITEMS as usize],
            len: 0,
            at: 0,
            renewal: self.renewals.now(),
        }
    }

    /// Sends a packet that stops the card. May be called at any time.
    pub(crate) fn stop(&self, packet: &Packet) -> Result<(), Lost> {
        self.device.send(packet.bytes())
    }
}

/// Largest number of packets that are read in a row while an answer is awaited or old ones are discarded.
pub(crate) const MAX_STRANGE: u32 = 64;

/// Returns the sequence number after `n`, which is never 0.
const fn after(n: u16) -> u16 {
    if n == u16::MAX { 1 } else { n + 1 }
}

/// Returns the low half of a time, of which differences below four seconds are right.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the low half")]
const fn low(ns: i64) -> u32 {
    ns as u32
}

/// Registers that a cycle writes.
#[derive(Debug)]
pub(crate) struct Outgoing<'l> {
    link: &'l Link,
    packet: Packet,
    number: u16,
    packets: u16,
    lost: Result<(), Lost>,
    /// Values for neighbouring registers from `at` on, which one command will write.
    run: [u32; MAX_ITEMS as usize],
    len: usize,
    at: u16,
    renewal: u32,
}

impl Outgoing<'_> {
    /// Returns a number that changes when everything has to be written again.
    pub(crate) const fn renewal(&self) -> u32 {
        self.renewal
    }

    /// Writes a register.
    pub(crate) fn put(&mut self, address: u16, value: u32) {
        let next = u32::from(self.at) + 4 * u32::try_from(self.len).unwrap_or(u32::MAX);
        if self.len == 0 || next != u32::from(address) || self.len == self.run.len() {
            self.close_run();
            self.at = address;
        }
        if let Some(slot) = self.run.get_mut(self.len) {
            *slot = value;
            self.len += 1;
        }
    }

    /// Writes a register once more, behind what was written to it before.
    pub(crate) fn put_again(&mut self, address: u16, value: u32) {
        self.close_run();
        self.put(address, value);
    }

    fn close_run(&mut self) {
        let (at, run) = (self.at, self.run.get(..self.len).unwrap_or_default());
        if run.is_empty() {
            return;
        }
        if !has_room(&self.packet, run.len()) {
            self.flush();
        }
        let run = self.run.get(..self.len).unwrap_or_default();
        // There is room: see above.
        let _ = self.packet.write_registers(at, run);
        self.len = 0;
    }

    /// Sends what was written so far as a packet of its own.
    fn flush(&mut self) {
        if usize::from(self.packets) >= MAX_WRITES {
            self.lost = Err(Lost::NONE);
            self.packet.clear();
            return;
        }
        let word = SCRATCH + 2 + 2 * self.packets;
        // `has_room` keeps room for it.
        let _ = self.packet.write_words(Space::Timers, word, &[self.number]);
        let sent = self.link.device.send(self.packet.bytes());
        self.lost = self.lost.and(sent);
        self.packets += 1;
        self.packet.clear();
    }

    /// Sends the rest.
    pub(crate) fn end(mut self) -> Result<(), Lost> {
        self.close_run();
        self.flush();
        self.link.wrote.store(self.number, Relaxed);
        self.link.packets.store(self.packets, Relaxed);
        self.lost
    }
}

/// Returns whether a packet has room for a command with `n` registers and for the sequence number.
fn has_room(packet: &Packet, n: usize) -> bool {
    packet.bytes().len() + 4 + 4 * n + 6 <= hal_lbp16::MAX_PACKET
}

/// Register that is written only when its value changes, or when everything is written again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    address: u16,
    value: u32,
    renewal: u32,
}

impl Kept {
    pub(crate) const fn new(address: u16) -> Self {
        Self { address, value: 0, renewal: 0 }
    }

    /// Writes the value if the register may hold another. Returns whether it was written.
    pub(crate) fn put(&mut self, to: &mut Outgoing<'_>, value: u32) -> bool {
        let is_new = self.value != value || self.renewal != to.renewal();
        if is_new {
            (self.value, self.renewal) = (value, to.renewal());
            to.put(self.address, value);
        }
        is_new
    }

    /// Makes the next value be written even if it is the same.
    pub(crate) const fn forget(&mut self) {
        self.renewal = 0;
    }
}

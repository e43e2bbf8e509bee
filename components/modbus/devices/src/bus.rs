//! A simulated line: time of characters, silence between frames, and faults by a seed.

use std::collections::VecDeque;

/// Largest number of bytes that wait for the master.
const MAX_WAITING: usize = 4096;
/// Largest number of answers on the line whose times are known.
const MAX_SPANS: usize = 64;
/// Room for a frame: up to this length, a line allocates nothing once it was made.
const ROOM: usize = 512;
/// Denominator of shares.
const WHOLE: f64 = 4_294_967_296.0;

/// Device, or devices, at the end of a line.
pub trait Device: Send {
    /// Lets the device go on to this moment of machine time, in nanoseconds.
    fn advance(&mut self, now_ns: i64);

    /// Takes bytes between two silences, and puts the answer into an empty buffer. Returns false if they are not for this device.
    fn hear(&mut self, frame: &[u8], now_ns: i64, answer: &mut Vec<u8>) -> bool;

    /// Takes bytes between two silences, and returns the answer, or nothing if they are not for this device.
    fn answered(&mut self, frame: &[u8], now_ns: i64) -> Option<Vec<u8>> {
        let mut answer = Vec::new();
        self.hear(frame, now_ns, &mut answer).then_some(answer)
    }
}

impl<D: Device> Device for Vec<D> {
    fn advance(&mut self, now_ns: i64) {
        self.iter_mut().for_each(|device| device.advance(now_ns));
    }

    fn hear(&mut self, frame: &[u8], now_ns: i64, answer: &mut Vec<u8>) -> bool {
        // All of them hear it.
        let answers: Vec<Vec<u8>> =
            self.iter_mut().filter_map(|device| device.answered(frame, now_ns)).collect();
        let first = answers.into_iter().next();
        answer.extend(first.iter().flatten());
        first.is_some()
    }
}

/// Times of a line, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Time of one character.
    pub char_ns: i64,
    /// Silence that separates frames: a frame that follows sooner is not heard.
    pub silence_ns: i64,
    /// Time that a device takes for its answer, beyond the silence.
    pub answer_ns: i64,
}

/// Faults of a line. Shares are 0 to 1 of the answers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// The cable is cut: nothing arrives anywhere.
    pub cut: bool,
    /// Share of answers with noise before them and a bit that is wrong.
    pub noise: f64,
    /// Share of answers of which only the first half arrives.
    pub half: f64,
    /// Share of answers that another device gives.
    pub other: f64,
    /// Time by which answers are late, in seconds.
    pub delay: f64,
}

/// The line with its devices.
#[derive(Debug)]
pub struct Bus<D> {
    /// Devices.
    pub devices: D,
    /// Faults.
    pub faults: Faults,
    timing: Timing,
    now: i64,
    /// Frame that devices hear now, and the time of its last character.
    heard: Vec<u8>,
    heard_until: i64,
    /// Time of the last character of the master.
    busy_until: i64,
    /// Answers on the line: times of their first and last characters.
    spans: VecDeque<(i64, i64)>,
    /// Time of the frame that the master sends later, and that frame.
    later_at: Option<i64>,
    later: Vec<u8>,
    /// Buffer for an answer.
    said: Vec<u8>,
    /// Bytes for the master, each with the time of its last character.
    waiting: VecDeque<(i64, u8)>,
    seed: u64,
    /// Number of frames that came too soon after the one before.
    hasty: u32,
}

impl<D: Device> Bus<D> {
    /// Returns a line without faults. The same seed gives the same faults.
    pub fn new(devices: D, timing: Timing, seed: u64) -> Self {
        Self {
            devices,
            faults: Faults { cut: false, noise: 0.0, half: 0.0, other: 0.0, delay: 0.0 },
            timing,
            now: 0,
            heard: Vec::with_capacity(ROOM),
            heard_until: 0,
            busy_until: i64::MIN / 2,
            spans: VecDeque::with_capacity(MAX_SPANS),
            later_at: None,
            later: Vec::with_capacity(ROOM),
            said: Vec::with_capacity(ROOM),
            waiting: VecDeque::with_capacity(MAX_WAITING),
            seed: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1,
            hasty: 0,
        }
    }

    /// Returns the number of frames that came too soon after the one before, and were not heard.
    pub const fn hasty(&self) -> u32 {
        self.hasty
    }

    /// Sends bytes at the time of the last [`Self::advance`].
    pub fn send(&mut self, bytes: &[u8]) {
        let count = i64::try_from(bytes.len()).unwrap_or(i64::MAX);
        let (begin, silence) = (self.now, self.timing.silence_ns);
        let end =
            begin.max(self.busy_until).saturating_add(self.timing.char_ns.saturating_mul(count));
        self.spans.retain(|(_, last)| begin < last.saturating_add(silence));
        let is_hasty = begin < self.busy_until.saturating_add(silence)
            || self.spans.iter().any(|(first, _)| *first < end);
        self.busy_until = end;
        if is_hasty {
            // Two frames in one: no device knows its own.
            self.hasty = self.hasty.wrapping_add(1);
            self.heard.clear();
            return;
        }
        if !self.faults.cut {
            self.heard.clear();
            self.heard.extend(bytes);
            self.heard_until = end;
        }
    }

    /// Lets the line and its devices go on to this moment, in nanoseconds.
    pub fn advance(&mut self, now_ns: i64) {
        let end = self.heard_until.saturating_add(self.timing.silence_ns);
        if !self.heard.is_empty() && end <= now_ns {
            self.devices.advance(end);
            let mut answer = core::mem::take(&mut self.said);
            answer.clear();
            if self.devices.hear(&self.heard, end, &mut answer) {
                self.answer(&mut answer, end);
            }
            self.said = answer;
            self.heard.clear();
        }
        if let Some(at) = self.later_at.take_if(|at| *at <= now_ns) {
            self.now = self.now.max(at);
            let frame = core::mem::take(&mut self.later);
            self.send(&frame);
            self.later = frame;
        }
        self.now = self.now.max(now_ns);
        self.devices.advance(self.now);
    }

    /// Sends bytes in so many nanoseconds.
    pub fn send_later(&mut self, bytes: &[u8], wait_ns: i64) {
        self.later_at = Some(self.now.saturating_add(wait_ns));
        self.later.clear();
        self.later.extend(bytes);
    }

    /// Returns the bytes that have come until the time of the last [`Self::advance`].
    pub fn receive(&mut self, most: usize) -> Vec<u8> {
        let ready = self.waiting.iter().take_while(|(at, _)| *at <= self.now).count();
        self.waiting.drain(..ready.min(most)).map(|(_, byte)| byte).collect()
    }

    fn answer(&mut self, answer: &mut Vec<u8>, heard: i64) {
        let Faults { cut, noise, half, other, delay } = self.faults;
        if self.draws(other)
            && let [unit, _, .., _] = answer.as_mut_slice()
        {
            *unit = unit.wrapping_add(1);
            answer.truncate(answer.len() - 2);
            hal_modbus::push_crc(answer);
        }
        if self.draws(half) {
            answer.truncate(answer.len() / 2);
        }
        if self.draws(noise) {
            let bit = self.random() % 8;
            if let Some(last) = answer.last_mut() {
                *last ^= 1 << bit;
            }
            let [a, b, c, ..] = self.random().to_le_bytes();
            answer.extend([a, b, c]);
            answer.rotate_right(3);
        }
        let answers = heard.saturating_add(self.timing.answer_ns);
        let mut at = answers.saturating_add(hal_modbus::nanoseconds(delay));
        let (first, mut last) = (at, at);
        for byte in answer.iter().copied() {
            at = at.saturating_add(self.timing.char_ns);
            last = at;
            if !cut && self.waiting.len() < MAX_WAITING {
                self.waiting.push_back((at, byte));
            }
        }
        if self.spans.len() == MAX_SPANS {
            self.spans.pop_front();
        }
        self.spans.push_back((first, last));
    }

    /// Returns true with this probability.
    fn draws(&mut self, share: f64) -> bool {
        0.0 < share && ((self.random() >> 32) as f64) < share * WHOLE
    }

    const fn random(&mut self) -> u64 {
        self.seed ^= self.seed >> 12;
        self.seed ^= self.seed << 25;
        self.seed ^= self.seed >> 27;
        self.seed.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }
}

#[cfg(test)]
mod tests {
    use super::{Bus, Faults, Timing};
    use crate::Inverter;
    use hal_modbus::huanyang::{Ask, RUN_FORWARD, STOP};

    impl<D> Bus<D> {
        fn rooms(&self) -> [usize; 5] {
            let frames = [&self.heard, &self.later, &self.said].map(Vec::capacity);
            let [heard, later, said] = frames;
            [heard, later, said, self.spans.capacity(), self.waiting.capacity()]
        }
    }

    /// A realtime function lets the time of a line pass where its worker stands still, and sends stops.
    #[test]
    fn a_line_needs_no_more_room_than_it_had_at_first() {
        const MS: i64 = 1_000_000;
        let timing = Timing { char_ns: MS, silence_ns: 4 * MS, answer_ns: 2 * MS };
        let mut bus = Bus::new(Inverter::new(1), timing, 7);
        bus.faults = Faults { noise: 0.3, half: 0.2, other: 0.3, delay: 0.1, cut: false };
        let rooms = bus.rooms();
        let asks = [
            Ask::Setting(4),
            Ask::Write(4, 40_000),
            Ask::Control(RUN_FORWARD),
            Ask::Measured(1),
            Ask::Frequency(20_000),
            Ask::Control(STOP),
        ];
        for n in 0..3000_usize {
            let frame = asks[n % asks.len()].frame(1);
            if n % 5 == 0 {
                bus.send_later(&frame, 3 * MS);
            } else {
                bus.send(&frame);
            }
            // Some follow too soon, and nobody reads the answers.
            bus.advance(i64::try_from(n).unwrap() * 40 * MS / (1 + i64::from(n % 7 == 0)));
            assert_eq!(bus.rooms(), rooms, "{n}");
        }
        assert!(bus.devices.frames() > 1000 && bus.waiting.len() == super::MAX_WAITING);
    }
}

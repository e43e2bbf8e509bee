//! A simulated line: time of characters, silence between frames, and faults by a seed.

use std::collections::VecDeque;

/// Largest number of bytes that wait for the master.
const MAX_WAITING: usize = 4096;
/// Denominator of shares.
const WHOLE: f64 = 4_294_967_296.0;

/// Device, or devices, at the end of a line.
pub trait Device: Send {
    /// Lets the device go on to this moment of machine time, in nanoseconds.
    fn advance(&mut self, now_ns: i64);

    /// Takes bytes between two silences, and returns the answer, or nothing if they are not for this device.
    fn hear(&mut self, frame: &[u8], now_ns: i64) -> Option<Vec<u8>>;
}

impl<D: Device> Device for Vec<D> {
    fn advance(&mut self, now_ns: i64) {
        self.iter_mut().for_each(|device| device.advance(now_ns));
    }

    fn hear(&mut self, frame: &[u8], now_ns: i64) -> Option<Vec<u8>> {
        // All of them hear it.
        let answers: Vec<Vec<u8>> =
            self.iter_mut().filter_map(|device| device.hear(frame, now_ns)).collect();
        answers.into_iter().next()
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
    /// Frame that the master sends later, with its time.
    later: Option<(i64, Vec<u8>)>,
    /// Bytes for the master, each with the time of its last character.
    waiting: VecDeque<(i64, u8)>,
    seed: u64,
    /// Number of frames that came too soon after the one before.
    hasty: u32,
}

impl<D: Device> Bus<D> {
    /// Returns a line without faults. The same seed gives the same faults.
    pub const fn new(devices: D, timing: Timing, seed: u64) -> Self {
        Self {
            devices,
            faults: Faults { cut: false, noise: 0.0, half: 0.0, other: 0.0, delay: 0.0 },
            timing,
            now: 0,
            heard: Vec::new(),
            heard_until: 0,
            busy_until: i64::MIN / 2,
            spans: VecDeque::new(),
            later: None,
            waiting: VecDeque::new(),
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
            self.heard = bytes.to_vec();
            self.heard_until = end;
        }
    }

    /// Lets the line and its devices go on to this moment, in nanoseconds.
    pub fn advance(&mut self, now_ns: i64) {
        let end = self.heard_until.saturating_add(self.timing.silence_ns);
        if !self.heard.is_empty() && end <= now_ns {
            let frame = core::mem::take(&mut self.heard);
            self.devices.advance(end);
            if let Some(answer) = self.devices.hear(&frame, end) {
                self.answer(answer, end);
            }
        }
        if let Some((at, frame)) = self.later.take_if(|(at, _)| *at <= now_ns) {
            self.now = self.now.max(at);
            self.send(&frame);
        }
        self.now = self.now.max(now_ns);
        self.devices.advance(self.now);
    }

    /// Sends bytes in so many nanoseconds.
    pub fn send_later(&mut self, bytes: &[u8], wait_ns: i64) {
        self.later = Some((self.now.saturating_add(wait_ns), bytes.to_vec()));
    }

    /// Returns the bytes that have come until the time of the last [`Self::advance`].
    pub fn receive(&mut self, most: usize) -> Vec<u8> {
        let ready = self.waiting.iter().take_while(|(at, _)| *at <= self.now).count();
        self.waiting.drain(..ready.min(most)).map(|(_, byte)| byte).collect()
    }

    fn answer(&mut self, mut answer: Vec<u8>, heard: i64) {
        let Faults { cut, noise, half, other, delay } = self.faults;
        if self.draws(other)
            && let Some((first, data)) = answer.split_first()
            && let Some(data) = data.split_last_chunk::<2>().map(|(data, _)| data)
        {
            let mut foreign = vec![first.wrapping_add(1)];
            foreign.extend(data);
            hal_modbus::push_crc(&mut foreign);
            answer = foreign;
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
            answer.splice(0..0, [a, b, c]);
        }
        let answers = heard.saturating_add(self.timing.answer_ns);
        let mut at = answers.saturating_add(hal_modbus::nanoseconds(delay));
        let (first, mut last) = (at, at);
        for byte in answer {
            at = at.saturating_add(self.timing.char_ns);
            last = at;
            if !cut && self.waiting.len() < MAX_WAITING {
                self.waiting.push_back((at, byte));
            }
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

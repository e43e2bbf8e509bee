//! Simulated controller of the robot: the server's end of the protocol, with its own motion, delays and faults.

use crate::{
    Answer, Command, FASTEST, Framer, Refusal, Volume, Zero,
    line::{CUTTING, QUIET, RAPID},
};
use std::collections::VecDeque;

/// Length of the retract at the connection, in millimetres.
const RETRACT: f64 = 50.0;
/// Time without a line after which the connection ends, in seconds.
const SILENCE: f64 = 60.0;
/// Time from a line to its answer, in seconds.
const ANSWER: f64 = 0.001;
/// Largest number of lines that wait.
const WAITING: usize = 64;

/// Faults of the answers on their way.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Faults {
    /// Seed of chance.
    pub seed: u64,
    /// Longest delay of an answer, in seconds.
    pub delay: f64,
    /// Share of answers that are lost, 0 to 1.
    pub lost: f64,
    /// Share of answers that come twice, 0 to 1.
    pub doubled: f64,
}

/// Output of the controller.
#[derive(Clone, PartialEq, Debug)]
pub enum Output {
    /// Bytes to the client.
    Bytes(Vec<u8>),
    /// End of the connection.
    Close,
}

/// Motion in a straight line.
#[derive(Clone, Copy, Debug)]
struct Motion {
    from: [f64; 3],
    to: [f64; 3],
    begin: f64,
    end: f64,
}

/// Simulated controller. Times are in seconds from any origin and never decrease.
#[derive(Debug)]
pub struct Controller {
    volume: Volume,
    zero: Zero,
    faults: Faults,
    chance: u64,
    is_connected: bool,
    has_started: bool,
    framer: Framer,
    waiting: VecDeque<Result<Command, Refusal>>,
    motion: Option<Motion>,
    /// True if the motion under way is that of a line, which must be answered.
    awaits_done: bool,
    at: [f64; 3],
    speed: f64,
    last_byte: f64,
    last_line: f64,
    last_answer: f64,
    answers: VecDeque<(f64, Vec<u8>)>,
    closing: bool,
    moves: Vec<[f64; 3]>,
}

impl Controller {
    /// Returns a controller whose tool touches the part zero.
    #[must_use]
    pub fn new(volume: Volume, zero: Zero, faults: Faults) -> Self {
        Self {
            volume,
            zero,
            faults,
            chance: faults.seed,
            is_connected: false,
            has_started: false,
            framer: Framer::default(),
            waiting: VecDeque::new(),
            motion: None,
            awaits_done: false,
            at: [0.0; 3],
            speed: CUTTING,
            last_byte: 0.0,
            last_line: 0.0,
            last_answer: 0.0,
            answers: VecDeque::new(),
            closing: false,
            moves: Vec::new(),
        }
    }

    /// Moves the tool, by hand, to a place in robot coordinates, where the next connection finds it; without a client alone.
    pub fn teach(&mut self, place: Zero) {
        if !self.is_connected {
            (self.zero, self.at, self.motion) = (place, [0.0; 3], None);
        }
    }

    /// Sets the faults of the answers from now on; their seed stays.
    pub const fn set_faults(&mut self, faults: Faults) {
        self.faults = Faults { seed: self.faults.seed, ..faults };
    }

    /// Returns the targets of all moves that were executed to their end, in the part frame.
    #[must_use]
    pub fn moves(&self) -> &[[f64; 3]] {
        &self.moves
    }

    /// Returns the tool's place in the part frame.
    #[must_use]
    pub fn place(&self, now: f64) -> [f64; 3] {
        self.motion.map_or(self.at, |m| m.at(now))
    }

    /// Returns whether the tool moves.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        self.motion.is_some()
    }

    /// Accepts a client: the place of the tool is the part zero from now on. While there is one, returns the answer for another, that the robot is busy; the caller sends it and
    /// closes that connection.
    pub fn connect(&mut self, now: f64) -> Option<Vec<u8>> {
        if self.is_connected {
            return Some(format!("{}\r\n", Answer::Refused(Refusal::Busy)).into_bytes());
        }
        let seed = self.chance;
        let zero = Volume::robot(&self.zero, self.place(now));
        let fresh = Self::new(self.volume, zero, self.faults);
        let moves = core::mem::take(&mut self.moves);
        *self = Self { moves, chance: seed, ..fresh };
        self.is_connected = true;
        (self.last_byte, self.last_line, self.last_answer) = (now, now, now);
        // The tool goes back from the part, and then the robot says where it stood.
        self.begin([0.0, 0.0, RETRACT], RAPID, now);
        None
    }

    /// Ends the connection: the tool stops where it is.
    pub fn disconnect(&mut self, now: f64) {
        self.halt(now);
        self.is_connected = false;
        self.waiting.clear();
        self.answers.clear();
    }

    /// Takes bytes from the client.
    pub fn receive(&mut self, bytes: &[u8], now: f64) {
        self.advance(now);
        self.last_byte = now;
        let mut lines = Vec::new();
        self.framer.feed(bytes, |line| lines.push(line.map(<[u8]>::to_vec)));
        for line in lines {
            self.line(line.as_deref(), now);
        }
        self.advance(now);
    }

    /// Advances to a time and returns what is due.
    pub fn poll(&mut self, now: f64) -> Vec<Output> {
        if !self.is_connected {
            return Vec::new();
        }
        if self.framer.has_begun() && now >= self.last_byte + QUIET {
            let mut last = None;
            self.framer.quiet(|line| last = Some(line.map(<[u8]>::to_vec)));
            if let Some(line) = last {
                self.line(line.as_deref(), now);
            }
        }
        self.advance(now);
        let is_silent = self.motion.is_none() && now >= self.last_line + SILENCE;
        let mut out = Vec::new();
        while self.answers.front().is_some_and(|(due, _)| *due <= now) {
            out.extend(self.answers.pop_front().map(|(_, bytes)| Output::Bytes(bytes)));
        }
        if self.closing || is_silent {
            self.disconnect(now);
            self.closing = false;
            out.push(Output::Close);
        }
        out
    }

    /// Returns when something happens next, if nothing is received.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        if !self.is_connected {
            return None;
        }
        let quiet = self.framer.has_begun().then_some(self.last_byte + QUIET);
        let silence = Some(self.last_line + SILENCE);
        let motion = self.motion.map(|m| m.end);
        let answer = self.answers.front().map(|(due, _)| *due);
        let end = self.closing.then_some(self.last_byte);
        let all = [end, quiet, silence.filter(|_| motion.is_none()), motion, answer];
        all.into_iter().flatten().reduce(f64::min)
    }

    fn line(&mut self, line: Option<&[u8]>, now: f64) {
        if self.closing {
            return;
        }
        self.last_line = now;
        let command = line.map_or(Err(Refusal::Format), Command::parse);
        if command == Ok(Command::Exit) || self.waiting.len() >= WAITING {
            self.halt(now);
            // Lines that wait would move the tool again.
            self.waiting.clear();
            self.closing = true;
            return;
        }
        self.waiting.push_back(command);
    }

    /// Executes waiting lines up to a time.
    fn advance(&mut self, now: f64) {
        loop {
            if let Some(motion) = self.motion {
                if motion.end > now {
                    return;
                }
                (self.at, self.motion) = (motion.to, None);
                if core::mem::take(&mut self.awaits_done) {
                    self.moves.push(motion.to);
                    self.answer(Answer::Done, motion.end);
                } else {
                    self.answer(Answer::Zero(self.zero), motion.end);
                    self.answer(Answer::Waiting, motion.end);
                }
                self.last_line = f64::max(self.last_line, motion.end);
            }
            let Some(command) = self.waiting.pop_front() else { return };
            let answer = command.and_then(|c| self.execute(&c, now));
            match answer {
                Ok(true) => self.answer(Answer::Done, now),
                Ok(false) => self.awaits_done = true,
                Err(why) => self.answer(Answer::Refused(why), now),
            }
        }
    }

    /// Executes a line; returns whether it is complete at once.
    fn execute(&mut self, command: &Command, now: f64) -> Result<bool, Refusal> {
        if *command == Command::Start {
            self.has_started = true;
            return Ok(true);
        }
        if !self.has_started {
            return Err(Refusal::Unknown);
        }
        match command {
            Command::Speed(v) if 0.0 < *v && *v <= FASTEST => {
                self.speed = *v;
                Ok(true)
            }
            Command::Speed(_) => Err(Refusal::Range),
            Command::Rapid(to) | Command::Cut(to) => {
                let point = Volume::robot(&self.zero, *to);
                self.volume.check(point).map_err(|_| Refusal::Range)?;
                let is_rapid = matches!(command, Command::Rapid(_));
                self.begin(*to, if is_rapid { RAPID } else { self.speed }, now);
                Ok(false)
            }
            Command::Start | Command::Exit => Ok(true),
        }
    }

    fn begin(&mut self, to: [f64; 3], speed: f64, now: f64) {
        let from = self.at;
        let way = libm::sqrt(from.iter().zip(&to).map(|(a, b)| (a - b) * (a - b)).sum());
        self.motion = Some(Motion { from, to, begin: now, end: now + way / speed });
    }

    fn halt(&mut self, now: f64) {
        self.at = self.place(now);
        self.motion = None;
        self.awaits_done = false;
    }

    /// Sends an answer, which keeps its place among the others.
    fn answer(&mut self, answer: Answer, now: f64) {
        let due = f64::max(self.last_answer, now + ANSWER + self.draw() * self.faults.delay);
        self.last_answer = due;
        let greets = matches!(answer, Answer::Zero(_) | Answer::Waiting);
        let is_lost = self.draw() < self.faults.lost && !greets;
        let is_doubled = self.draw() < self.faults.doubled && !greets;
        let times = usize::from(!is_lost) + usize::from(!is_lost && is_doubled);
        let bytes = format!("{answer}\r\n").into_bytes();
        self.answers.extend(core::iter::repeat_n((due, bytes), times));
    }

    /// Returns a number from 0 to 1 by chance (splitmix64; Steele, Lea and Flood, 2014).
    fn draw(&mut self) -> f64 {
        self.chance = self.chance.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.chance;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 9_007_199_254_740_992.0
    }
}

impl Motion {
    fn at(&self, now: f64) -> [f64; 3] {
        // Before the begin there is no time to ask for.
        if now >= self.end {
            return self.to;
        }
        let part = f64::max(0.0, now - self.begin) / (self.end - self.begin);
        let mut out = self.from;
        for (out, to) in out.iter_mut().zip(self.to) {
            *out += (to - *out) * part;
        }
        out
    }
}

//! Client's end of the protocol: one line at a time, each executed exactly once.

use crate::{Answer, Command, Framer, Refusal, Zero};
use std::{collections::VecDeque, fmt};

/// Time after which an answer without an end counts as whole, in seconds.
const QUIET: f64 = 0.05;
/// Time after which a paused driver shows the robot that it is still there, in seconds.
const ALIVE: f64 = 20.0;
/// Largest number of probes for one line.
const PROBES: u32 = 10;

/// State of the driver.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum State {
    /// There is no connection.
    Closed,
    /// The robot has not yet said where it stands.
    Connected,
    /// The robot waits; the part zero is known.
    Ready,
    /// Lines are executed.
    Running,
    /// The line under way ends, and no other follows.
    Paused,
    /// All lines are executed.
    Ended,
    /// The run has stopped.
    Stopped(Stopped),
}

/// Reason why a run has stopped, with the index of the line that has no answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stopped {
    /// The user has stopped it.
    User(usize),
    /// The connection has ended.
    Lost(usize),
    /// The robot does not answer any more.
    Silent(usize),
    /// The robot has refused the line.
    Refused(usize, Refusal),
    /// Another client is connected.
    Busy,
}

/// News for the user.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Event {
    /// The part zero.
    Zero(Zero),
    /// A line was sent: its index.
    Sent(usize),
    /// A line was executed: its index, and whether its own answer came.
    Executed(usize, bool),
    /// Text that is no answer was received, or an overlong one.
    Noise,
}

impl Stopped {
    /// Returns the index of the line with which a run can resume.
    #[must_use]
    pub const fn line(&self) -> Option<usize> {
        match self {
            Self::User(n) | Self::Lost(n) | Self::Silent(n) | Self::Refused(n, _) => Some(*n),
            Self::Busy => None,
        }
    }
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::User(n) => write!(f, "stopped at line {n}"),
            Self::Lost(n) => write!(f, "the connection was lost at line {n}"),
            Self::Silent(n) => write!(f, "the robot does not answer line {n}"),
            Self::Refused(n, why) => write!(f, "the robot refused line {n}: {why}"),
            Self::Busy => f.write_str("another client is connected to the robot"),
        }
    }
}

/// Exchange under way.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Phase {
    /// None.
    Idle,
    /// A line waits for its answer.
    Answer { since: f64 },
    /// A probe waits for its refusal.
    Probe { since: f64, tries: u32, is_answered: bool },
}

/// Driver of one run. Times are in seconds from any origin and never decrease.
#[derive(Debug)]
pub struct Driver {
    state: State,
    zero: Option<Zero>,
    timeout: f64,
    framer: Framer,
    last_byte: f64,
    lines: Vec<Command>,
    /// Lines to send before the next of `lines`: they begin a run.
    first: VecDeque<Command>,
    next: usize,
    phase: Phase,
    /// Kind of the probe; it changes with every line, so that a late answer to the probe before is recognised.
    is_odd: bool,
    last_sent: f64,
    out: Vec<u8>,
    events: Vec<Event>,
}

impl Driver {
    /// Returns a driver. `timeout` is the time for the answer to a line, in seconds; it must be longer than any move.
    #[must_use]
    pub const fn new(timeout: f64) -> Self {
        Self {
            state: State::Closed,
            zero: None,
            timeout,
            framer: Framer::new(),
            last_byte: 0.0,
            lines: Vec::new(),
            first: VecDeque::new(),
            next: 0,
            phase: Phase::Idle,
            is_odd: false,
            last_sent: 0.0,
            out: Vec::new(),
            events: Vec::new(),
        }
    }

    /// Returns the state.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// Returns the part zero.
    #[must_use]
    pub const fn zero(&self) -> Option<Zero> {
        self.zero
    }

    /// Begins with a new connection.
    pub fn connected(&mut self, now: f64) {
        *self = Self { state: State::Connected, last_byte: now, ..Self::new(self.timeout) };
    }

    /// Ends with the connection. What is unanswered stays so.
    pub fn disconnected(&mut self) {
        self.phase = Phase::Idle;
        self.state = match self.state {
            State::Running | State::Paused => State::Stopped(Stopped::Lost(self.next)),
            State::Connected | State::Ready => State::Closed,
            other @ (State::Closed | State::Ended | State::Stopped(_)) => other,
        };
    }

    /// Runs lines from an index on; a cutting speed that was set before it is set again. Returns false unless the robot is
    /// ready.
    pub fn run(&mut self, lines: Vec<Command>, from: usize, now: f64) -> bool {
        if self.state != State::Ready {
            return false;
        }
        let speeds = lines.iter().take(from).rev();
        let speed = speeds.copied().find(|c| matches!(c, Command::Speed(_)));
        self.first = [Some(Command::Start), speed].into_iter().flatten().collect();
        (self.lines, self.next) = (lines, from);
        self.state = State::Running;
        self.advance(now);
        true
    }

    /// Sends nothing more after the line under way.
    pub fn pause(&mut self) {
        if self.state == State::Running {
            self.state = State::Paused;
        }
    }

    /// Goes on after a pause.
    pub fn resume(&mut self, now: f64) {
        if self.state == State::Paused {
            self.state = State::Running;
            if self.phase == Phase::Idle {
                self.advance(now);
            }
        }
    }

    /// Stops the move under way at once, and ends the connection.
    pub fn stop(&mut self) {
        if matches!(self.state, State::Connected | State::Running | State::Paused | State::Ready) {
            self.send(&Command::Exit);
            self.phase = Phase::Idle;
            self.state = State::Stopped(Stopped::User(self.next));
        }
    }

    /// Takes bytes from the robot.
    pub fn receive(&mut self, bytes: &[u8], now: f64) {
        self.last_byte = now;
        let mut lines = Vec::new();
        self.framer.feed(bytes, |line| lines.push(line.and_then(Answer::parse)));
        for answer in lines {
            self.answer(answer, now);
        }
    }

    /// Advances to a time.
    pub fn poll(&mut self, now: f64) {
        if self.framer.has_begun() && now >= self.last_byte + QUIET {
            let mut last = None;
            self.framer.quiet(|line| last = Some(line.and_then(Answer::parse)));
            if let Some(answer) = last {
                self.answer(answer, now);
            }
        }
        match self.phase {
            Phase::Answer { since } if now >= since + self.timeout => {
                self.probe(Phase::Probe { since: now, tries: 1, is_answered: false });
            }
            Phase::Probe { since, tries, is_answered } if now >= since + self.timeout => {
                if tries >= PROBES {
                    self.phase = Phase::Idle;
                    self.state = State::Stopped(Stopped::Silent(self.next));
                } else {
                    self.probe(Phase::Probe { since: now, tries: tries + 1, is_answered });
                }
            }
            // The probe of the line before: its answer is ignored wherever it comes.
            Phase::Idle if self.state == State::Paused && now >= self.last_sent + ALIVE => {
                self.last_sent = now;
                self.out.extend_from_slice(Self::words(!self.is_odd));
            }
            Phase::Idle | Phase::Answer { .. } | Phase::Probe { .. } => {}
        }
    }

    /// Returns when something happens next, if nothing is received.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        let quiet = self.framer.has_begun().then_some(self.last_byte + QUIET);
        let timeout = match self.phase {
            Phase::Idle => (self.state == State::Paused).then_some(self.last_sent + ALIVE),
            Phase::Answer { since } | Phase::Probe { since, .. } => Some(since + self.timeout),
        };
        [quiet, timeout].into_iter().flatten().reduce(f64::min)
    }

    /// Returns the bytes to send.
    pub fn output(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.out)
    }

    /// Returns the news.
    pub fn events(&mut self) -> Vec<Event> {
        core::mem::take(&mut self.events)
    }

    fn answer(&mut self, answer: Option<Answer>, now: f64) {
        match (answer, self.phase) {
            (Some(Answer::Zero(zero)), _) if self.state == State::Connected => {
                self.zero = Some(zero);
                self.events.push(Event::Zero(zero));
            }
            (Some(Answer::Waiting), _) if self.state == State::Connected && self.zero.is_some() => {
                self.state = State::Ready;
            }
            (Some(Answer::Refused(Refusal::Busy)), _) => {
                self.phase = Phase::Idle;
                self.state = State::Stopped(Stopped::Busy);
            }
            (Some(Answer::Done), Phase::Answer { .. }) => {
                self.probe(Phase::Probe { since: now, tries: 1, is_answered: true });
            }
            (Some(Answer::Refused(why)), Phase::Probe { is_answered, .. })
                if why == self.expected() =>
            {
                self.executed(is_answered, now);
            }
            // The answer to the probe before, once more.
            (Some(Answer::Refused(why)), Phase::Answer { .. } | Phase::Probe { .. })
                if why == Self::refusal(!self.is_odd) => {}
            (Some(Answer::Refused(why)), Phase::Answer { .. } | Phase::Probe { .. }) => {
                self.phase = Phase::Idle;
                self.state = State::Stopped(Stopped::Refused(self.next, why));
                self.send(&Command::Exit);
            }
            (Some(Answer::Done), _) | (Some(Answer::Refused(_)), Phase::Idle) => {}
            (Some(Answer::Zero(_) | Answer::Waiting) | None, _) => self.events.push(Event::Noise),
        }
    }

    const fn refusal(is_odd: bool) -> Refusal {
        if is_odd { Refusal::Format } else { Refusal::Unknown }
    }

    /// Returns the answer to the probe of this line.
    const fn expected(&self) -> Refusal {
        Self::refusal(self.is_odd)
    }

    fn probe(&mut self, phase: Phase) {
        self.phase = phase;
        self.out.extend_from_slice(Self::words(self.is_odd));
    }

    const fn words(is_odd: bool) -> &'static [u8] {
        if is_odd { b"SPEED\r\n" } else { b"?\r\n" }
    }

    fn executed(&mut self, is_answered: bool, now: f64) {
        self.is_odd = !self.is_odd;
        self.phase = Phase::Idle;
        self.last_sent = now;
        if self.first.pop_front().is_none() {
            self.events.push(Event::Executed(self.next, is_answered));
            self.next += 1;
        }
        if self.state == State::Running {
            self.advance(now);
        }
    }

    /// Sends the next line, or the end.
    fn advance(&mut self, now: f64) {
        let line = self.first.front().or_else(|| self.lines.get(self.next)).copied();
        let Some(line) = line else {
            self.send(&Command::Exit);
            self.state = State::Ended;
            return;
        };
        if self.first.is_empty() {
            self.events.push(Event::Sent(self.next));
        }
        self.send(&line);
        self.phase = Phase::Answer { since: now };
    }

    fn send(&mut self, command: &Command) {
        self.out.extend_from_slice(format!("{command}\r\n").as_bytes());
    }
}

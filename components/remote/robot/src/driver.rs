//! Client's end of the protocol: one line at a time, each executed exactly once.

use crate::{
    Answer, Command, Event, Framer, Refusal, State, Stopped, Zero,
    line::{CUTTING, QUIET, RAPID},
    program::approach,
};
use std::collections::VecDeque;

/// Time after which a driver that is ready or paused shows the robot that it is still there, in seconds.
const ALIVE: f64 = 20.0;
/// Time from a connection to the greeting of the robot, which retracts first, in seconds.
const GREETING: f64 = 60.0;
/// Place of the tool behind the retract, in the part frame: from elsewhere a probe only comes earlier than it must.
const RETRACTED: [f64; 3] = [0.0, 0.0, 50.0];
/// Largest number of probes without an answer.
const PROBES: u32 = 10;

/// Exchange under way.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Phase {
    /// None.
    Idle,
    /// A line waits for its answer.
    Answer { since: f64 },
    /// A probe waits for its refusal. `answered` tells whether the line before was answered in its time; `None` if that
    /// line is complete, and the probe only takes what is left of the answers to the probes before it.
    Probe { since: f64, tries: u32, answered: Option<bool> },
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
    /// Refusal of the line, or a late copy of the answer to the probe before: its `done` will tell.
    doubt: Option<Refusal>,
    last_sent: f64,
    /// Target of the last move.
    at: [f64; 3],
    /// Cutting speed.
    speed: f64,
    /// Time for the answer to the line under way, its move included.
    wait: f64,
    out: Vec<u8>,
    events: Vec<Event>,
}

impl Driver {
    /// Returns a driver. `timeout` is the time for the answer to a line behind the end of its move, in seconds.
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
            doubt: None,
            last_sent: 0.0,
            at: RETRACTED,
            speed: CUTTING,
            wait: 0.0,
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

    /// Returns whether a line has been sent that is not known to be executed: the robot may move.
    #[must_use]
    pub const fn awaits_line(&self) -> bool {
        matches!(self.phase, Phase::Answer { .. } | Phase::Probe { answered: Some(_), .. })
    }

    /// Begins with a new connection.
    pub fn connected(&mut self, now: f64) {
        let new = Self::new(self.timeout);
        *self = Self { state: State::Connected, last_byte: now, last_sent: now, ..new };
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

    /// Runs lines from an index on, behind [`approach`]. Returns false unless the robot is ready.
    pub fn run(&mut self, lines: Vec<Command>, from: usize, now: f64) -> bool {
        if self.state != State::Ready {
            return false;
        }
        self.first = approach(&lines, from).into();
        (self.lines, self.next) = (lines, from);
        self.state = State::Running;
        // A probe on its way has its answer first.
        if self.phase == Phase::Idle {
            self.advance(now);
        }
        true
    }

    /// Forgets a connection that was ended on purpose.
    pub fn closed(&mut self) {
        *self = Self::new(self.timeout);
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
            Phase::Answer { since } if now >= since + self.wait => {
                self.probe(now, 1, Some(false));
            }
            Phase::Probe { since, tries, answered } if now >= since + self.timeout => {
                if tries >= PROBES {
                    self.silent();
                } else {
                    self.probe(now, tries + 1, answered);
                }
            }
            Phase::Idle if self.state == State::Connected && now >= self.last_sent + GREETING => {
                self.silent();
            }
            Phase::Idle if self.is_resting() && now >= self.last_sent + ALIVE => {
                self.probe(now, 1, None);
            }
            Phase::Idle | Phase::Answer { .. } | Phase::Probe { .. } => {}
        }
    }

    /// Returns when something happens next, if nothing is received.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        let quiet = self.framer.has_begun().then_some(self.last_byte + QUIET);
        let timeout = match self.phase {
            Phase::Idle if self.state == State::Connected => Some(self.last_sent + GREETING),
            Phase::Idle => self.is_resting().then_some(self.last_sent + ALIVE),
            Phase::Answer { since } => Some(since + self.wait),
            Phase::Probe { since, .. } => Some(since + self.timeout),
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
            (Some(Answer::Done), Phase::Answer { .. }) => self.probe(now, 1, Some(true)),
            (Some(Answer::Done), Phase::Probe { since, tries, .. }) if self.doubt.is_some() => {
                self.doubt = None;
                self.phase = Phase::Probe { since, tries, answered: Some(true) };
            }
            (Some(Answer::Refused(why)), Phase::Probe { tries, answered, .. })
                if why == Self::refusal(self.is_odd) =>
            {
                match (answered, self.doubt) {
                    (Some(false), Some(why)) => self.refused(why),
                    _ => self.probed(tries, answered, now),
                }
            }
            // The answer to the probe before once more, or the line is refused with the same word.
            (Some(Answer::Refused(why)), phase @ (Phase::Answer { .. } | Phase::Probe { .. }))
                if why == Self::refusal(!self.is_odd) =>
            {
                // What comes before the line has left is no answer to it.
                let is_awaited = matches!(phase, Phase::Answer { .. }) && self.out.is_empty();
                if is_awaited {
                    self.probe(now, 1, Some(false));
                }
                if is_awaited || matches!(phase, Phase::Probe { answered: Some(false), .. }) {
                    self.doubt = Some(why);
                }
            }
            (Some(Answer::Refused(why)), Phase::Answer { .. } | Phase::Probe { .. }) => {
                self.refused(why);
            }
            (Some(Answer::Done), Phase::Idle | Phase::Probe { .. })
            | (Some(Answer::Refused(_)), Phase::Idle) => {}
            (Some(Answer::Zero(_) | Answer::Waiting) | None, _) => self.events.push(Event::Noise),
        }
    }

    /// Returns whether the robot waits for a line, and the driver for the user.
    fn is_resting(&self) -> bool {
        matches!(self.state, State::Ready | State::Paused)
    }

    const fn refusal(is_odd: bool) -> Refusal {
        if is_odd { Refusal::Format } else { Refusal::Unknown }
    }

    fn silent(&mut self) {
        self.phase = Phase::Idle;
        self.state = State::Stopped(Stopped::Silent(self.next));
        self.send(&Command::Exit);
    }

    fn refused(&mut self, why: Refusal) {
        self.phase = Phase::Idle;
        self.state = State::Stopped(Stopped::Refused(self.next, why));
        self.send(&Command::Exit);
    }

    fn probe(&mut self, now: f64, tries: u32, answered: Option<bool>) {
        self.phase = Phase::Probe { since: now, tries, answered };
        let words: &[u8] = if self.is_odd { b"SPEED\r\n" } else { b"?\r\n" };
        self.out.extend_from_slice(words);
    }

    /// Goes on after the answer to a probe. Where it was sent more than once, further answers may come: another probe takes
    /// them, so that they are not held for the refusal of the next line.
    fn probed(&mut self, tries: u32, answered: Option<bool>, now: f64) {
        self.is_odd = !self.is_odd;
        self.phase = Phase::Idle;
        self.doubt = None;
        self.last_sent = now;
        if let Some(is_answered) = answered
            && self.first.pop_front().is_none()
        {
            self.events.push(Event::Executed(self.next, is_answered));
            self.next += 1;
        }
        if tries > 1 {
            self.probe(now, 1, None);
        } else if self.state == State::Running {
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
        self.wait = self.timeout + self.duration(&line);
        self.phase = Phase::Answer { since: now };
    }

    /// Returns how long a line takes, in seconds, and notes what it changes.
    fn duration(&mut self, line: &Command) -> f64 {
        if let Command::Speed(speed) = line {
            self.speed = *speed;
        }
        let Some(to) = line.target() else { return 0.0 };
        let from = core::mem::replace(&mut self.at, to);
        let way = libm::sqrt(from.iter().zip(&to).map(|(a, b)| (a - b) * (a - b)).sum());
        way / if matches!(line, Command::Rapid(_)) { RAPID } else { self.speed }
    }

    fn send(&mut self, command: &Command) {
        self.out.extend_from_slice(format!("{command}\r\n").as_bytes());
    }
}

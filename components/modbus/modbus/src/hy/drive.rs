//! Conversation with an inverter: a state machine over requests, answers and times.

mod results;

use super::{note::Note, pins::Inputs, question::HyQuestion};
use hal_modbus::{
    Miss,
    huanyang::{Ask, RUN_FORWARD, RUN_REVERSE, STOP, measured, setting, state},
};
use port::Lost;

/// Settings that are read.
const READ: [u8; 7] = [
    setting::MAX_FREQUENCY,
    setting::BASE_FREQUENCY,
    setting::MIN_FREQUENCY,
    setting::MOTOR_VOLTAGE,
    setting::MOTOR_CURRENT,
    setting::MOTOR_POLES,
    setting::MOTOR_TURNS,
];
/// Measurements of one round, the most wanted first.
const ROUND: [u8; 8] = [
    measured::FREQUENCY,
    measured::SET_FREQUENCY,
    measured::CURRENT,
    measured::TURNS,
    measured::DC,
    measured::AC,
    measured::COUNTER,
    measured::TEMPERATURE,
];

/// Stage of the conversation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Nothing is said, once the inverter has answered a stop.
    Off,
    /// A stop is said, whatever the inverter does.
    First,
    /// Settings are written.
    Write,
    /// Settings are read.
    Read(usize),
    /// Commands and measurements go round.
    Round,
}

/// The conversation with one inverter.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    unit: u8,
    /// Settings to write, with their values, and the number of those that are written: each is written once.
    writes: Vec<(u8, u16)>,
    written: usize,
    /// The inverter does not take a setting.
    is_refused: bool,
    timeout_ns: i64,
    stage: Stage,
    wanted: Inputs,
    settings: [u16; READ.len()],
    measured: [u16; ROUND.len()],
    /// Command that was answered last.
    command: Option<u8>,
    /// Frequency that was answered last.
    frequency: Option<u16>,
    /// State that the inverter answered last.
    state: u8,
    /// A command to run was sent, and no stop was answered since.
    may_run: bool,
    /// No stop was answered since the load: the inverter may run by the command of a process that was killed.
    is_unknown: bool,
    /// The inverter was seen to run by the command that was answered last.
    has_run: bool,
    /// Place in the round.
    turn: usize,
    last_answer: i64,
    /// A request failed since the last answer, or the line is not open.
    has_failed: bool,
    is_lost: bool,
    /// Number of times after which a person has to command the spindle again.
    lapses: u32,
    requests: u32,
    answers: u32,
    errors: [u32; Miss::KINDS],
    losses: u32,
    last_error: i32,
    last_miss: Miss,
    is_answered: bool,
    note: Option<Note>,
}

impl Drive {
    pub(crate) fn new(unit: u8, writes: Vec<(u8, u16)>, timeout_ns: i64) -> Self {
        Self {
            unit,
            writes,
            written: 0,
            is_refused: false,
            timeout_ns,
            stage: Stage::Off,
            wanted: Inputs::default(),
            settings: [0; READ.len()],
            measured: [0; ROUND.len()],
            command: None,
            frequency: None,
            state: 0,
            may_run: false,
            is_unknown: true,
            has_run: false,
            turn: 0,
            last_answer: 0,
            has_failed: false,
            is_lost: false,
            lapses: 0,
            requests: 0,
            answers: 0,
            errors: [0; Miss::KINDS],
            losses: 0,
            last_error: 0,
            last_miss: Miss::Silent,
            is_answered: false,
            note: None,
        }
    }

    /// Returns whether the inverter may turn: it was told to, and has answered no stop since.
    pub(crate) const fn may_run(&self) -> bool {
        self.may_run
    }

    /// Returns whether there is anything to say.
    pub(crate) const fn speaks(&self) -> bool {
        self.is_unknown || self.is_due()
    }

    /// Returns whether an inverter that does not answer is lost.
    const fn is_due(&self) -> bool {
        self.may_run || !matches!(self.stage, Stage::Off)
    }

    /// Returns whether the inverter does not answer for longer than it may.
    pub(crate) const fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Returns what came last instead of an answer.
    pub(crate) const fn last_miss(&self) -> Miss {
        self.last_miss
    }

    /// Takes the event that a person has to know.
    pub(crate) const fn take_note(&mut self) -> Option<Note> {
        self.note.take()
    }

    /// Takes what the function wants.
    pub(crate) fn want(&mut self, wanted: Inputs, now: i64) {
        self.wanted = wanted;
        if wanted.enable && self.stage == Stage::Off {
            self.stage = Stage::First;
            if !self.may_run {
                self.last_answer = now;
            }
        } else if !wanted.enable && self.stage != Stage::Off {
            self.stage = Stage::Off;
            self.lapses = self.lapses.wrapping_add(1);
        }
        // Time in which nothing was asked, as while the worker stood still, is no fault of the inverter.
        let is_late = self.is_due()
            && self.has_failed
            && self.timeout_ns < now.saturating_sub(self.last_answer);
        if is_late && !self.is_lost {
            self.is_lost = true;
            self.lapse();
        }
        if !self.is_due() {
            (self.is_lost, self.is_answered, self.has_failed) = (false, false, false);
        }
    }

    /// Says a stop next, and nothing else until a person has commanded the spindle again.
    pub(crate) fn lapse(&mut self) {
        self.lapses = self.lapses.wrapping_add(1);
        (self.command, self.has_run) = (None, false);
        if self.stage != Stage::Off {
            self.stage = Stage::First;
        }
    }

    /// Returns what to say next.
    pub(crate) fn next(&mut self) -> Option<HyQuestion> {
        let ask = match self.stage {
            Stage::Off if self.speaks() => Ask::Control(STOP),
            Stage::Off => return None,
            Stage::First => Ask::Control(STOP),
            Stage::Write => {
                let (number, value) = self.writes.get(self.written).copied().unwrap_or_default();
                Ask::Write(number, value)
            }
            Stage::Read(n) => Ask::Setting(READ.get(n).copied().unwrap_or_default()),
            Stage::Round => self.round(),
        };
        if let Ask::Control(command @ (RUN_FORWARD | RUN_REVERSE)) = ask {
            self.may_run = true;
            // Until it is answered, a stop is as urgent as if it were.
            self.command = self.command.filter(|answered| *answered == command);
        }
        Some(HyQuestion { unit: self.unit, ask })
    }

    /// Notes that what was next is sent.
    pub(crate) const fn sent(&mut self) {
        self.requests = self.requests.saturating_add(1);
    }

    /// Returns the next of a round. What changes goes first.
    fn round(&self) -> Ask {
        let (command, frequency) = self.command();
        if self.command != Some(STOP) && command == STOP {
            return Ask::Control(STOP);
        }
        if let Some(frequency) = frequency
            && self.frequency != Some(frequency)
        {
            return Ask::Frequency(frequency);
        }
        if self.command != Some(command) {
            return Ask::Control(command);
        }
        match (self.turn.checked_sub(2), frequency) {
            (None, Some(frequency)) if self.turn == 1 => Ask::Frequency(frequency),
            (None, _) => Ask::Control(command),
            (Some(n), _) => Ask::Measured(ROUND.get(n).copied().unwrap_or_default()),
        }
    }

    /// Returns the command and the frequency that are wanted.
    fn command(&self) -> (u8, Option<u16>) {
        let frequency = self.frequency_for(self.wanted.speed);
        let command = match self.wanted.run {
            _ if frequency.is_none() || self.wanted.seen != self.lapses => STOP,
            1 => RUN_FORWARD,
            -1 => RUN_REVERSE,
            _ => STOP,
        };
        (command, frequency)
    }

    /// Returns the frequency for a speed, in 0.01 Hz, within the limits of the inverter. A speed of 0 has none.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within u16")]
    fn frequency_for(&self, speed: f64) -> Option<u16> {
        let [top, _, low, ..] = self.settings;
        let hundredths = speed.abs() / self.turns() * f64::from(top);
        if !(0.0 < hundredths && hundredths.is_finite()) {
            return None;
        }
        let limited = hundredths.min(f64::from(top)).max(f64::from(low.min(top)));
        Some((limited + 0.5).min(65535.0) as u16)
    }

    /// Returns the turns per minute at the greatest frequency.
    fn turns(&self) -> f64 {
        let [top, .., turns] = self.settings;
        f64::from(turns) * f64::from(top) / 5000.0
    }

    /// Takes the end of a request.
    pub(crate) fn ended(&mut self, ask: Ask, end: Result<u16, Miss>, now: i64) {
        let value = match end {
            Ok(value) => value,
            Err(miss) => return self.missed(miss),
        };
        self.answers = self.answers.saturating_add(1);
        self.last_answer = now;
        (self.is_lost, self.is_answered, self.has_failed) = (false, true, false);
        match (self.stage, ask) {
            (_, Ask::Control(command)) => self.commanded(command, value),
            (Stage::Write, Ask::Write(number, sent)) => {
                if value == sent {
                    self.written += 1;
                } else {
                    self.is_refused = true;
                    self.note = Some(Note::Refused(number, sent, value));
                }
                self.stage = self.after_stop();
            }
            (Stage::Read(n), Ask::Setting(_)) => {
                if let Some(setting) = self.settings.get_mut(n) {
                    *setting = value;
                }
                let is_last = READ.len() <= n + 1;
                (self.turn, self.frequency) = (0, None);
                self.stage = if is_last { Stage::Round } else { Stage::Read(n + 1) };
            }
            (_, Ask::Frequency(frequency)) => {
                self.frequency = Some(frequency);
                if self.turn == 1 {
                    self.turn = 2;
                }
            }
            (Stage::Round, Ask::Measured(number)) => {
                if let Some(measured) = self.measured.get_mut(usize::from(number)) {
                    *measured = value;
                }
                self.turn = (self.turn + 1) % (ROUND.len() + 2);
            }
            _ => {}
        }
    }

    fn commanded(&mut self, command: u8, state: u16) {
        let [state, _] = state.to_le_bytes();
        self.state = state;
        let is = |bit: u8| state & bit != 0;
        if command == STOP {
            if is(state::RUN) {
                // The late answer to a command to run: the stop is still to be answered.
                return;
            }
            (self.may_run, self.is_unknown, self.has_run) = (false, false, false);
        } else {
            // In another direction the motor goes through rest.
            let did_run = self.has_run && self.command == Some(command);
            if did_run && !is(state::RUNNING) {
                self.note = Some(Note::Stopped);
                return self.lapse();
            }
            let is_meant = is(state::RUNNING_REVERSE) == (command == RUN_REVERSE);
            self.has_run = did_run || is(state::RUNNING) && is_meant;
        }
        self.command = Some(command);
        match self.stage {
            Stage::First if command == STOP => self.stage = self.after_stop(),
            Stage::Round if self.turn == 0 => {
                self.turn = if self.command().1.is_some() { 1 } else { 2 };
            }
            _ => {}
        }
    }

    /// Returns the stage behind an answered stop. Without all its settings an inverter hears nothing but stops.
    const fn after_stop(&self) -> Stage {
        if self.is_refused {
            Stage::First
        } else if self.written < self.writes.len() {
            Stage::Write
        } else {
            Stage::Read(0)
        }
    }

    fn missed(&mut self, miss: Miss) {
        (self.is_answered, self.has_failed) = (false, true);
        if let Some(count) = self.errors.get_mut(miss.kind()) {
            *count = count.saturating_add(1);
        }
        self.last_miss = miss;
        self.last_error = if miss == Miss::Silent { -12 } else { -16 };
    }

    /// Notes that the line is lost.
    pub(crate) fn lost(&mut self, lost: Lost) {
        (self.is_answered, self.has_failed) = (false, true);
        self.losses = self.losses.saturating_add(1);
        self.last_error = -lost.0;
        self.lapse();
    }

    /// Notes that the line cannot be opened.
    pub(crate) const fn not_opened(&mut self) {
        self.has_failed = true;
    }
}

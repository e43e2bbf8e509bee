//! Conversation with an inverter: a state machine over requests, answers and times.

use super::pins::Results;
use crate::station::{Failure, Question};
use hal_modbus::{
    Miss,
    huanyang::{self, Ask, RUN_FORWARD, RUN_REVERSE, STOP, measured, state},
};

/// Settings that are read, by their numbers: maximum, base and least frequency, voltage, current, poles, turns.
const READ: [u8; 7] = [5, 4, 11, 141, 142, 143, 144];
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

/// Request to one inverter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HyQuestion {
    pub(crate) unit: u8,
    pub(crate) ask: Ask,
}

impl Question for HyQuestion {
    type Answer = u16;

    fn find(&self, bytes: &[u8]) -> Result<Option<u16>, Miss> {
        Ok(huanyang::find(self.unit, self.ask, bytes))
    }

    fn miss(&self, bytes: &[u8]) -> Miss {
        huanyang::miss(self.unit, bytes)
    }
}

/// Demands of the function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Demand {
    /// The inverter is spoken to.
    pub(crate) enable: bool,
    /// Direction: 0 to stand, 1 forward, -1 reverse.
    pub(crate) run: i32,
    /// Speed in turns per minute.
    pub(crate) speed: f64,
    /// Number of lapses that the function has seen. A run is commanded only by a function that has seen all of them.
    pub(crate) seen: u32,
}

/// Stage of the conversation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Nothing is said, once the inverter has answered a stop.
    Off,
    /// A stop is said, whatever the inverter does.
    First,
    /// Settings are written.
    Write(usize),
    /// Settings are read.
    Read(usize),
    /// Commands and measurements go round.
    Round,
}

/// The conversation with one inverter.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    unit: u8,
    /// Settings to write, with their values.
    writes: Vec<(u8, u16)>,
    timeout_ns: i64,
    stage: Stage,
    wanted: Demand,
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
    /// Place in the round.
    turn: usize,
    last_answer: i64,
    is_lost: bool,
    /// Number of times after which a person has to command the spindle again.
    lapses: u32,
    requests: u32,
    answers: u32,
    errors: [u32; Miss::KINDS.len()],
    losses: u32,
    last_error: i32,
    is_answered: bool,
}

impl Drive {
    pub(crate) fn new(unit: u8, writes: Vec<(u8, u16)>, timeout_ns: i64) -> Self {
        Self {
            unit,
            writes,
            timeout_ns,
            stage: Stage::Off,
            wanted: Demand::default(),
            settings: [0; READ.len()],
            measured: [0; ROUND.len()],
            command: None,
            frequency: None,
            state: 0,
            may_run: false,
            turn: 0,
            last_answer: 0,
            is_lost: false,
            lapses: 0,
            requests: 0,
            answers: 0,
            errors: [0; Miss::KINDS.len()],
            losses: 0,
            last_error: 0,
            is_answered: false,
        }
    }

    /// Returns whether the inverter may turn: it was told to, and has answered no stop since.
    pub(crate) const fn may_run(&self) -> bool {
        self.may_run
    }

    /// Returns whether there is anything to say.
    pub(crate) const fn speaks(&self) -> bool {
        self.may_run || !matches!(self.stage, Stage::Off)
    }

    /// Returns whether the inverter does not answer for longer than it may.
    pub(crate) const fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Takes what the function wants.
    pub(crate) fn want(&mut self, wanted: Demand, now: i64) {
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
        let is_late = self.speaks() && self.timeout_ns < now.saturating_sub(self.last_answer);
        if is_late && !self.is_lost {
            self.is_lost = true;
            self.lapse();
        }
        if !self.speaks() {
            (self.is_lost, self.is_answered) = (false, false);
        }
    }

    /// Says a stop next, and nothing else until a person has commanded the spindle again.
    pub(crate) fn lapse(&mut self) {
        self.lapses = self.lapses.wrapping_add(1);
        self.command = None;
        if self.stage != Stage::Off {
            self.stage = Stage::First;
        }
    }

    /// Returns what to say next.
    pub(crate) fn next(&mut self) -> Option<HyQuestion> {
        let ask = match self.stage {
            Stage::Off if self.may_run => Ask::Control(STOP),
            Stage::Off => return None,
            Stage::First => Ask::Control(STOP),
            Stage::Write(n) => {
                let (number, value) = self.writes.get(n).copied().unwrap_or_default();
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
        self.requests = self.requests.wrapping_add(1);
        Some(HyQuestion { unit: self.unit, ask })
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
    pub(crate) fn ended(&mut self, ask: Ask, end: Result<u16, Failure>, now: i64) {
        let value = match end {
            Ok(value) => value,
            Err(failure) => return self.failed(failure),
        };
        self.answers = self.answers.wrapping_add(1);
        self.last_answer = now;
        (self.is_lost, self.is_answered) = (false, true);
        match (self.stage, ask) {
            (_, Ask::Control(command)) => self.commanded(command, value),
            (Stage::Write(n), Ask::Write(..)) => self.stage = self.after_write(n),
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
        self.command = Some(command);
        if command == STOP {
            self.may_run = false;
        }
        match self.stage {
            Stage::First if command == STOP => {
                self.stage = if self.writes.is_empty() { Stage::Read(0) } else { Stage::Write(0) };
            }
            Stage::Round if self.turn == 0 => {
                self.turn = if self.command().1.is_some() { 1 } else { 2 };
            }
            _ => {}
        }
    }

    const fn after_write(&self, n: usize) -> Stage {
        if n + 1 < self.writes.len() { Stage::Write(n + 1) } else { Stage::Read(0) }
    }

    fn failed(&mut self, failure: Failure) {
        self.is_answered = false;
        match failure {
            Failure::Missed(miss) => {
                if let Some(count) = self.errors.get_mut(miss.kind()) {
                    *count = count.wrapping_add(1);
                }
                self.last_error = if miss == Miss::Silent { -12 } else { -16 };
            }
            Failure::Lost(lost) => {
                self.losses = self.losses.wrapping_add(1);
                self.last_error = -lost.0;
            }
        }
    }

    /// Returns what the pins show.
    pub(crate) fn results(&self, now: i64) -> Results {
        let [.., poles, _] = self.settings;
        let [top, base, low, voltage, current, ..] = self.settings.map(f64::from);
        let [set, out, amperes, turns, dc, ac, counter, temperature] = self.measured.map(f64::from);
        let (command, frequency) = self.command();
        let is = |bit: u8| self.state & bit != 0;
        let speed_fb = if top == 0.0 { 0.0 } else { out / top * self.turns() };
        Results {
            set_f: set * 0.01,
            out_f: out * 0.01,
            out_a: amperes * 0.1,
            rott: turns,
            dcv: dc,
            acv: ac,
            cont: counter,
            tmp: temperature,
            cntr: f64::from(if self.stage == Stage::Round { command } else { 0 }),
            cnst: f64::from(self.state),
            cnst_run: is(state::RUN),
            cnst_jog: is(state::JOG),
            cnst_command_rf: is(state::COMMAND_REVERSE),
            cnst_running: is(state::RUNNING),
            cnst_jogging: is(state::JOGGING),
            cnst_running_rf: is(state::RUNNING_REVERSE),
            cnst_bracking: is(state::BRAKING),
            cnst_track_start: is(state::TRACKING),
            spindle_speed_fb: speed_fb,
            frequency_command: frequency.map_or(0.0, f64::from),
            max_freq: top * 0.01,
            base_freq: base * 0.01,
            freq_lower_limit: low * 0.01,
            rated_motor_voltage: voltage * 0.1,
            rated_motor_current: current * 0.1,
            rated_motor_rev: self.turns(),
            motor_poles: u32::from(poles),
            hycomm_ok: self.is_answered,
            fault: self.is_lost,
            requests: self.requests,
            answers: self.answers,
            errors_silent: self.errors[0],
            errors_other: self.errors[1],
            errors_wrong: self.errors[2],
            errors_noise: self.errors[3],
            errors_line: self.losses,
            since_answer: now.saturating_sub(self.last_answer) as f64 * 1e-9,
            last_error: self.last_error,
            ready: self.stage == Stage::Round && !self.is_lost,
            lapses: self.lapses,
        }
    }
}

//! The worker of a line.

use super::{
    config::TransactionConfig,
    pins::{HealthPins, SimulatedValues, ValuePins},
    probe::{self, Inbox, Probe},
    schedule::Schedule,
    simulation::Simulation,
};
use crate::{
    line::{LinePlace, NotOpened, OpenLine},
    station::{LineLoss, Question, Station},
};
use hal_component::{Clock, Hardware, Messages, Texts, Touch, Work};
use hal_modbus::{Miss, ModbusAnswer, ModbusRequest, find_rtu, find_tcp};
use port::{Exchange as _, Lost};
use std::sync::Arc;

/// Time between attempts to open a line, in nanoseconds.
const REOPEN_NS: i64 = 1_000_000_000;
/// Time for the answer to a probe, in nanoseconds.
const PROBE_NS: i64 = 500_000_000;
/// Shortest time without an answer that is a fault, in nanoseconds.
const FAULT_NS: i64 = 1_000_000_000;
/// Largest number of requests that end in one step.
const MOST: usize = 8;
/// Largest number of different texts about a line.
const LINE_TEXTS: usize = 100;
/// Largest number of different texts with what devices answer.
const ANSWER_TEXTS: usize = 500;
/// Error of a connection whose bytes are no frames (EPROTO).
const NO_FRAMES: Lost = Lost(71);

/// Origin of a request.
#[derive(Debug)]
enum Asker {
    Transaction(usize),
    Probe(Probe),
}

/// Request under way.
#[derive(Debug)]
pub(crate) struct MbQuestion {
    request: ModbusRequest,
    /// Number of the request, over TCP.
    number: Option<u16>,
    asker: Asker,
}

impl Question for MbQuestion {
    type Answer = ModbusAnswer;

    fn answer_len(&self) -> usize {
        self.request.answer_len()
    }

    fn find(&self, bytes: &[u8]) -> Result<Option<ModbusAnswer>, Miss> {
        match self.number {
            Some(number) => find_tcp(&self.request, number, bytes),
            None => Ok(find_rtu(&self.request, bytes)),
        }
    }

    fn miss(&self, bytes: &[u8]) -> Miss {
        match self.number {
            Some(_) => Miss::Silent,
            None => Miss::of_rtu(&self.request, bytes),
        }
    }
}

/// A transaction with its pins and its state.
#[derive(Debug, Touch)]
pub(crate) struct Transaction {
    pub(crate) values: ValuePins,
    pub(crate) health: HealthPins,
    pub(crate) simulated: Option<SimulatedValues>,
    #[state]
    pub(crate) config: TransactionConfig,
    #[state]
    pub(crate) counts: Counts,
}

/// Counters of a transaction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    answers: u32,
    errors: [u32; Miss::KINDS],
    refused: u32,
    lost: u32,
    last_answer: i64,
    /// A request failed since the last answer.
    has_failed: bool,
    is_fault: bool,
    is_refused: bool,
}

impl Transaction {
    /// Returns the time without an answer that is a fault.
    fn fault_ns(&self) -> i64 {
        let TransactionConfig { period_ns, timeout_ns, .. } = self.config;
        FAULT_NS.max(2 * (period_ns + timeout_ns))
    }

    fn show(&self, now: i64) {
        let Counts { answers, errors, refused, lost, last_answer, is_fault, .. } = self.counts;
        let missed =
            errors.iter().fold(refused.saturating_add(lost), |sum, n| sum.saturating_add(*n));
        self.health.num_errors.set(missed);
        self.health.answers.set(answers);
        self.health.errors.iter().zip(errors).for_each(|(pin, count)| pin.set(count));
        self.health.refused.set(refused);
        self.health.since.set(now.saturating_sub(last_answer) as f64 * 1e-9);
        self.health.fault.set(is_fault);
    }
}

/// The worker of a line.
#[derive(Touch)]
pub(crate) struct LinkWorker {
    pub(crate) transactions: Vec<Transaction>,
    pub(crate) simulation: Option<Simulation>,
    pub(crate) clock: Clock,
    pub(crate) messages: Messages,
    /// Switches motion off while a device is lost, if that was wanted.
    pub(crate) hardware: Option<Hardware>,
    #[state]
    pub(crate) prefix: String,
    #[state]
    pub(crate) link: usize,
    #[state]
    pub(crate) place: LinePlace,
    #[state]
    pub(crate) station: Station<MbQuestion>,
    #[state]
    pub(crate) schedule: Schedule,
    #[state]
    pub(crate) inbox: Inbox,
    #[state]
    pub(crate) state: LinkState,
}

/// State that the worker keeps from one step to the next.
pub(crate) struct LinkState {
    line: Option<Arc<OpenLine>>,
    reopen: i64,
    why: Option<NotOpened>,
    /// Texts about the line, and about devices that do not answer.
    texts: Texts,
    /// Texts with what devices answer: however many they are, the others are still said.
    answers: Texts,
    number: u16,
    has_begun: bool,
}

impl LinkState {
    /// Returns the state of a line with so many transactions.
    pub(crate) const fn new(transactions: usize) -> Self {
        Self {
            line: None,
            reopen: i64::MIN,
            why: None,
            texts: Texts::new(LINE_TEXTS + 2 * transactions),
            answers: Texts::new(ANSWER_TEXTS),
            number: 0,
            has_begun: false,
        }
    }
}

impl LinkWorker {
    fn is_tcp(&self) -> bool {
        matches!(self.place, LinePlace::Tcp(_))
    }

    fn say(&mut self, text: &str) {
        self.messages.error(self.state.texts.keep(text), &[]);
    }

    /// Lets the simulated devices have what the pins say.
    fn simulate(&mut self) {
        let Some(simulation) = &self.simulation else { return };
        let mut bus = simulation.line.bus();
        bus.faults = simulation.faults.faults();
        for slave in &mut bus.devices.list {
            let own = || self.transactions.iter().filter(|t| t.config.unit == slave.unit);
            slave.is_silent =
                own().filter_map(|t| t.simulated.as_ref()).any(SimulatedValues::is_silent);
        }
        for transaction in &self.transactions {
            let (of, pins) = (&transaction.config, &transaction.simulated);
            let slave = bus.devices.list.iter_mut().find(|slave| slave.unit == of.unit);
            if let (Some(slave), Some(pins)) = (slave, pins) {
                pins.exchange(of, slave);
            }
        }
    }

    /// Returns the line, which is opened if it is time to.
    fn line(&mut self, now: i64) -> Option<Arc<OpenLine>> {
        if self.state.line.is_none() && self.state.reopen <= now {
            self.state.reopen = now.saturating_add(REOPEN_NS);
            let opened = match &self.simulation {
                Some(simulation) => Ok(OpenLine::new(simulation.line.clone())),
                None => self.place.open(),
            };
            match opened {
                Ok(line) => (self.state.line, self.state.why) = (Some(Arc::new(line)), None),
                Err(why) => {
                    if self.state.why.as_ref() != Some(&why) {
                        self.say(&why.to_string());
                        self.state.why = Some(why);
                    }
                    while let Some(probe) = probe::take(&self.inbox, self.link) {
                        probe.ticket.fail("the line is not open: the log has the reason");
                    }
                }
            }
        }
        self.state.line.clone()
    }

    /// Ends the request under way, if there is one, and closes the line.
    fn lost(&mut self, loss: LineLoss<MbQuestion>, now: i64) {
        let text = format!("{} is lost ({})", self.place, loss.lost);
        self.say(&text);
        self.state.line = None;
        match loss.question.map(|question| question.asker) {
            Some(Asker::Probe(probe)) => probe.ticket.fail("the line was lost"),
            Some(Asker::Transaction(n)) => {
                if let Some(transaction) = self.transactions.get_mut(n) {
                    transaction.counts.lost = transaction.counts.lost.saturating_add(1);
                    transaction.counts.has_failed = true;
                    self.schedule.silent(n, now);
                }
            }
            None => {}
        }
    }

    fn ended(&mut self, question: MbQuestion, end: Result<ModbusAnswer, Miss>, now: i64) {
        match question.asker {
            Asker::Probe(probe) => self.probed(&probe, &end),
            Asker::Transaction(n) => self.counted(n, &end, now),
        }
        // Over TCP, bytes that are no frame leave nothing to begin again with.
        if self.is_tcp() && end.is_err_and(|miss| miss != Miss::Silent) {
            self.lost(LineLoss { question: None, lost: NO_FRAMES }, now);
        }
    }

    fn probed(&mut self, probe: &Probe, end: &Result<ModbusAnswer, Miss>) {
        let unit = probe.request.unit;
        match end {
            Ok(answer @ (ModbusAnswer::Bits(_) | ModbusAnswer::Words(_))) => {
                let text = format!("device {unit} answers: {}", probe::values(answer));
                self.messages.notice(self.state.answers.keep(&text), &[]);
                probe.ticket.done();
            }
            Ok(answer) => {
                let text = format!("device {unit}: {}", probe::values(answer));
                probe.ticket.fail(self.state.answers.keep(&text));
            }
            Err(miss) => {
                let text = format!("device {unit}: {miss}");
                probe.ticket.fail(self.state.answers.keep(&text));
            }
        }
    }

    fn counted(&mut self, n: usize, end: &Result<ModbusAnswer, Miss>, now: i64) {
        let Some(transaction) = self.transactions.get_mut(n) else { return };
        let counts = &mut transaction.counts;
        counts.has_failed = true;
        match end {
            Ok(ModbusAnswer::Refused(exception)) => {
                counts.refused = counts.refused.saturating_add(1);
                self.schedule.refused(n, now);
                if !core::mem::replace(&mut counts.is_refused, true) {
                    let text = format!("{}.{}: {exception}", self.prefix, transaction.config.name);
                    self.messages.error(self.state.answers.keep(&text), &[]);
                }
            }
            Ok(answer) => {
                counts.answers = counts.answers.saturating_add(1);
                (counts.last_answer, counts.has_failed, counts.is_refused) = (now, false, false);
                transaction.values.show(answer);
                self.schedule.answered(n, now);
            }
            Err(miss) => {
                if let Some(count) = counts.errors.get_mut(miss.kind()) {
                    *count = count.saturating_add(1);
                }
                match miss {
                    Miss::Silent => self.schedule.silent(n, now),
                    _ => self.schedule.broken(n, now),
                }
            }
        }
    }

    /// Sends the next request, if it is time to.
    fn ask(&mut self, line: &OpenLine, now: i64) {
        if !self.station.is_free(now) {
            return;
        }
        let (request, asker, within) = if let Some(probe) = probe::take(&self.inbox, self.link) {
            (probe.request.clone(), Asker::Probe(probe), PROBE_NS)
        } else if let Some((n, t)) =
            self.schedule.next(now).and_then(|n| Some((n, self.transactions.get(n)?)))
        {
            (t.values.request(&t.config), Asker::Transaction(n), t.config.timeout_ns)
        } else {
            return;
        };
        let number = self.is_tcp().then(|| {
            self.state.number = self.state.number.wrapping_add(1);
            self.state.number
        });
        let frame = match number {
            Some(number) => request.tcp(number),
            None => request.rtu(),
        };
        // The numbers of elements were checked before.
        let Ok(frame) = frame else { return };
        let question = MbQuestion { request, number, asker };
        if let Err(loss) = self.station.ask(line, question, &frame, within, now) {
            self.lost(loss, now);
        }
    }

    fn judge(&mut self, now: i64) {
        let mut fault = false;
        let is_closed = self.state.line.is_none();
        for n in 0..self.transactions.len() {
            let Some(transaction) = self.transactions.get_mut(n) else { break };
            // A slow line, whose other requests take their time, is no fault of a device.
            let has_failed = is_closed
                || transaction.counts.has_failed
                || self.schedule.is_silent(transaction.config.unit);
            let late = now.saturating_sub(transaction.counts.last_answer);
            let is_fault = has_failed && transaction.fault_ns() < late;
            let was = core::mem::replace(&mut transaction.counts.is_fault, is_fault);
            transaction.show(now);
            fault |= is_fault;
            if is_fault != was {
                let config = &transaction.config;
                let (name, unit) = (&config.name, config.unit);
                let state = if is_fault { "does not answer" } else { "answers again" };
                let text =
                    format!("{}.{name}: device {unit} on {} {state}", self.prefix, self.place);
                let text = self.state.texts.keep(&text);
                if is_fault {
                    self.messages.error(text, &[]);
                } else {
                    self.messages.notice(text, &[]);
                }
            }
        }
        if let Some(hardware) = &mut self.hardware {
            hardware.note(fault);
        }
    }
}

impl Work for LinkWorker {
    fn work(&mut self, _: u32) -> u32 {
        let now = self.clock.now_ns();
        if !core::mem::replace(&mut self.state.has_begun, true) {
            self.transactions.iter_mut().for_each(|t| t.counts.last_answer = now);
        }
        self.simulate();
        if let Some(line) = self.line(now) {
            line.advance(now);
            for _ in 0..MOST {
                let has_ended = match self.station.poll(&line, now) {
                    Ok(ended) => {
                        ended.map(|(question, end)| self.ended(question, end, now)).is_some()
                    }
                    Err(loss) => {
                        self.lost(loss, now);
                        break;
                    }
                };
                if self.state.line.is_some() {
                    self.ask(&line, now);
                }
                if !has_ended {
                    break;
                }
            }
        }
        self.simulate();
        self.judge(now);
        0
    }
}

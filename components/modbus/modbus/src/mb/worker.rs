//! The worker of a line.

use super::{
    config::TransactionConfig,
    pins::{HealthPins, SimulatedValues, ValuePins},
    probe::{self, Inbox, Probe},
    schedule::Schedule,
};
use crate::{
    line::{LinePlace, NotOpened, OpenLine, SimulatedFaultPins, SimulatedLine},
    station::{Failure, Question, Station},
};
use hal_component::{Clock, Hardware, Messages, Texts, Touch, Work};
use hal_modbus::{Miss, ModbusAnswer, ModbusRequest, find_rtu, find_tcp};
use hal_modbus_devices::{Device, Slave};
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
    errors: [u32; Miss::KINDS.len()],
    refused: u32,
    lost: u32,
    last_answer: i64,
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
        let missed = errors.iter().fold(refused.wrapping_add(lost), |sum, n| sum.wrapping_add(*n));
        self.health.num_errors.set(missed);
        self.health.answers.set(answers);
        self.health.errors.iter().zip(errors).for_each(|(pin, count)| pin.set(count));
        self.health.refused.set(refused);
        self.health.since.set(now.saturating_sub(last_answer) as f64 * 1e-9);
        self.health.fault.set(is_fault);
    }
}

/// Simulated devices of a line.
#[derive(Debug)]
pub(crate) struct Slaves {
    pub(crate) list: Vec<Slave>,
    /// Frames are those of TCP.
    pub(crate) is_tcp: bool,
}

impl Device for Slaves {
    fn advance(&mut self, _: i64) {}

    fn hear(&mut self, frame: &[u8], now_ns: i64) -> Option<Vec<u8>> {
        if !self.is_tcp {
            return self.list.hear(frame, now_ns);
        }
        let unit = frame.get(6)?;
        self.list.iter_mut().find(|slave| slave.unit == *unit)?.hear_tcp(frame)
    }
}

/// Simulation of a line.
#[derive(Debug, Touch)]
pub(crate) struct Simulation {
    pub(crate) faults: SimulatedFaultPins,
    #[state]
    pub(crate) line: SimulatedLine<Slaves>,
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
    way: Option<Arc<OpenLine>>,
    reopen: i64,
    why: Option<NotOpened>,
    texts: Texts,
    number: u16,
    has_begun: bool,
}

impl LinkState {
    pub(crate) const fn new() -> Self {
        Self {
            way: None,
            reopen: i64::MIN,
            why: None,
            texts: Texts::new(500),
            number: 0,
            has_begun: false,
        }
    }
}

impl LinkWorker {
    fn is_tcp(&self) -> bool {
        matches!(self.place, LinePlace::Tcp(_))
    }

    fn say(&mut self, text: &str) -> &'static str {
        let text = self.state.texts.keep(text);
        self.messages.error(text, &[]);
        text
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
    fn way(&mut self, now: i64) -> Option<Arc<OpenLine>> {
        if self.state.way.is_none() && self.state.reopen <= now {
            self.state.reopen = now.saturating_add(REOPEN_NS);
            let opened = match &self.simulation {
                Some(simulation) => Ok(OpenLine::new(simulation.line.clone())),
                None => self.place.open(),
            };
            match opened {
                Ok(way) => (self.state.way, self.state.why) = (Some(Arc::new(way)), None),
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
        self.state.way.clone()
    }

    fn lost(&mut self, lost: Lost) {
        let text = format!("{} is lost ({lost})", self.place);
        self.say(&text);
        self.state.way = None;
        self.station.forget();
    }

    fn ended(&mut self, question: MbQuestion, end: Result<ModbusAnswer, Failure>, now: i64) {
        match question.asker {
            Asker::Probe(probe) => self.probed(&probe, &end),
            Asker::Transaction(n) => self.counted(n, &end, now),
        }
        match end {
            Err(Failure::Lost(lost)) => self.lost(lost),
            // Over TCP, bytes that are no frame leave nothing to begin again with.
            Err(Failure::Missed(miss)) if self.is_tcp() && miss != Miss::Silent => {
                self.lost(NO_FRAMES);
            }
            _ => {}
        }
    }

    fn probed(&mut self, probe: &Probe, end: &Result<ModbusAnswer, Failure>) {
        let unit = probe.request.unit;
        match end {
            Ok(answer @ (ModbusAnswer::Bits(_) | ModbusAnswer::Words(_))) => {
                let text = format!("device {unit} answers: {}", probe::values(answer));
                self.messages.notice(self.state.texts.keep(&text), &[]);
                probe.ticket.done();
            }
            Ok(answer) => {
                let text = format!("device {unit}: {}", probe::values(answer));
                probe.ticket.fail(self.state.texts.keep(&text));
            }
            Err(Failure::Missed(miss)) => {
                let text = format!("device {unit}: {miss}");
                probe.ticket.fail(self.state.texts.keep(&text));
            }
            Err(Failure::Lost(_)) => probe.ticket.fail("the line was lost"),
        }
    }

    fn counted(&mut self, n: usize, end: &Result<ModbusAnswer, Failure>, now: i64) {
        let Some(transaction) = self.transactions.get_mut(n) else { return };
        let counts = &mut transaction.counts;
        match end {
            Ok(ModbusAnswer::Refused(exception)) => {
                counts.refused = counts.refused.wrapping_add(1);
                self.schedule.silent(n, now);
                if !core::mem::replace(&mut counts.is_refused, true) {
                    let text = format!("{}.{}: {exception}", self.prefix, transaction.config.name);
                    self.say(&text);
                }
            }
            Ok(answer) => {
                counts.answers = counts.answers.wrapping_add(1);
                (counts.last_answer, counts.is_refused) = (now, false);
                transaction.values.show(answer);
                self.schedule.answered(n, now);
            }
            Err(Failure::Missed(miss)) => {
                if let Some(count) = counts.errors.get_mut(miss.kind()) {
                    *count = count.wrapping_add(1);
                }
                match miss {
                    Miss::Silent => self.schedule.silent(n, now),
                    _ => self.schedule.broken(n, now),
                }
            }
            Err(Failure::Lost(_)) => {
                counts.lost = counts.lost.wrapping_add(1);
                self.schedule.silent(n, now);
            }
        }
    }

    /// Sends the next request, if it is time to.
    fn ask(&mut self, way: &OpenLine, now: i64) {
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
        if let Err((question, lost)) = self.station.ask(way, question, &frame, within, now) {
            self.ended(question, Err(Failure::Lost(lost)), now);
        }
    }

    fn judge(&mut self, now: i64) {
        let mut fault = false;
        for n in 0..self.transactions.len() {
            let Some(transaction) = self.transactions.get_mut(n) else { break };
            let is_fault =
                transaction.fault_ns() < now.saturating_sub(transaction.counts.last_answer);
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
        if let Some(way) = self.way(now) {
            way.advance(now);
            for _ in 0..MOST {
                let ended = self.station.poll(&way, now);
                let has_ended = ended.is_some();
                if let Some((question, end)) = ended {
                    self.ended(question, end, now);
                }
                if self.state.way.is_some() {
                    self.ask(&way, now);
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

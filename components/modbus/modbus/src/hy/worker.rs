//! The worker of an inverter: it keeps the line open and the conversation going.

use super::{
    drive::Drive,
    halt::Halt,
    pins::{Inputs, Results},
    question::HyQuestion,
    simulated::InverterLine,
};
use crate::{
    line::{NotOpened, OpenLine, SerialPlace},
    station::Station,
};
use hal_component::{Clock, Messages, SeqReader, SeqWriter, Texts, Touch, Work};
use hal_modbus::Miss;
use port::{Exchange as _, Lost};
use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// Time for an answer, in nanoseconds.
const ANSWER_NS: i64 = 100_000_000;
/// Time without a cycle of the function after which the inverter is stopped, in nanoseconds.
const IDLE_NS: i64 = 200_000_000;
/// Time between attempts to open a line, in nanoseconds.
const REOPEN_NS: i64 = 500_000_000;
/// Largest number of requests that end in one step.
const MOST: usize = 4;
/// Largest number of different messages.
const MESSAGES: usize = 50;

/// Place of the inverter.
#[derive(Clone, Debug)]
pub(crate) enum InverterPlace {
    Serial(SerialPlace),
    Simulated(InverterLine),
}

impl InverterPlace {
    /// Opens the line.
    pub(crate) fn open(&self) -> Result<OpenLine, NotOpened> {
        match self {
            Self::Serial(place) => place.open().map(OpenLine::new),
            Self::Simulated(line) => Ok(OpenLine::new(line.clone())),
        }
    }
}

/// The worker.
#[derive(Touch)]
pub(crate) struct Worker {
    pub(crate) wanted: SeqReader<Inputs>,
    pub(crate) results: SeqWriter<Results>,
    pub(crate) clock: Clock,
    pub(crate) messages: Messages,
    #[state]
    pub(crate) place: InverterPlace,
    #[state]
    pub(crate) station: Station<HyQuestion>,
    #[state]
    pub(crate) drive: Drive,
    #[state]
    pub(crate) halt: Arc<Halt>,
    #[state]
    pub(crate) steps: Arc<AtomicU32>,
    #[state]
    pub(crate) state: WorkerState,
}

/// State that the worker keeps from one step to the next.
pub(crate) struct WorkerState {
    line: Option<Arc<OpenLine>>,
    /// Time of the next attempt to open the line.
    reopen: i64,
    /// Number of cycles of the function, and the time at which it last changed.
    cycles: (u32, i64),
    is_idle: bool,
    was_lost: bool,
    /// Reason for the last failure to open the line.
    why: Option<NotOpened>,
    texts: Texts,
}

impl WorkerState {
    pub(crate) const fn new() -> Self {
        Self {
            line: None,
            reopen: i64::MIN,
            cycles: (0, 0),
            is_idle: true,
            was_lost: false,
            why: None,
            texts: Texts::new(MESSAGES),
        }
    }
}

impl Worker {
    /// Takes what the function wants, and notices when it stands still.
    fn listen(&mut self, now: i64) {
        if self.halt.flags.notice() {
            self.drive.lapse();
        }
        let inputs = self.wanted.get();
        if inputs.cycles != self.state.cycles.0 {
            self.state.cycles = (inputs.cycles, now);
        }
        let is_idle = IDLE_NS < now.saturating_sub(self.state.cycles.1);
        if is_idle && !self.state.is_idle {
            self.drive.lapse();
            if self.drive.may_run() {
                self.messages.error(
                    "the function of the inverter does not run: the inverter is stopped",
                    &[],
                );
            }
        }
        self.state.is_idle = is_idle;
        self.drive.want(inputs, now);
    }

    /// Returns the line, which is opened if it is time to.
    fn line(&mut self, now: i64) -> Option<Arc<OpenLine>> {
        if self.state.line.is_none() && self.drive.speaks() && self.state.reopen <= now {
            self.state.reopen = now.saturating_add(REOPEN_NS);
            match self.place.open() {
                Ok(line) => {
                    self.state.line = Some(Arc::new(line));
                    self.state.why = None;
                    self.halt.on(self.state.line.clone());
                }
                Err(why) => {
                    self.drive.not_opened();
                    if self.state.why.as_ref() != Some(&why) {
                        self.messages.error(self.state.texts.keep(&why.to_string()), &[]);
                        self.state.why = Some(why);
                    }
                }
            }
        }
        self.state.line.clone()
    }

    fn lost(&mut self, lost: Lost) {
        self.messages
            .error("the serial line of the inverter is lost (error {})", &[f64::from(lost.0)]);
        self.halt.on(None);
        self.state.line = None;
        // The inverter may have gone on without the line: it stops when it hears anything again.
        self.drive.lost(lost);
    }

    /// Lets the conversation go on. Returns whether a request has ended.
    fn speak(&mut self, line: &OpenLine, now: i64) -> bool {
        let ended = match self.station.poll(line, now) {
            Ok(ended) => ended,
            Err(loss) => {
                self.lost(loss.lost);
                return false;
            }
        };
        let has_ended = ended.is_some();
        if let Some((question, end)) = ended {
            self.drive.ended(question.ask, end, now);
        }
        // After a stop of the instance the next step says a stop, and this one nothing more.
        if self.station.is_free(now)
            && let Some(question) = self.drive.next()
            && self.halt.flags.may_send(self.drive.may_run())
        {
            let frame = question.ask.frame(question.unit);
            match self.station.ask(line, question, &frame, ANSWER_NS, now) {
                Ok(()) => self.drive.sent(),
                Err(loss) => self.lost(loss.lost),
            }
        }
        self.halt.set_quiet_at(self.station.quiet_at());
        has_ended
    }

    /// Says in the log what a person has to know: that the inverter is lost, and that it is back.
    fn tell(&mut self) {
        if let Some(note) = self.drive.take_note() {
            self.messages.error(self.state.texts.keep(&note.to_string()), &[]);
        }
        let is_lost = self.drive.is_lost();
        if is_lost == core::mem::replace(&mut self.state.was_lost, is_lost) {
            return;
        }
        if is_lost {
            let why = match self.drive.last_miss() {
                _ if self.state.line.is_none() => "its line is not open",
                Miss::Silent => "nothing comes: check power, wires, rate, and PD163 to PD165",
                Miss::Noise => "what comes is no answer: check rate, parity, number and wires",
                Miss::Other(_) => "another device answers: check its number, PD163",
                Miss::Wrong => "what comes answers something else",
            };
            let text =
                format!("the inverter does not answer ({why}): it is stopped, and motion is off");
            self.messages.error(self.state.texts.keep(&text), &[]);
        } else {
            self.messages.notice(
                "the inverter answers again: it stands until a person commands the spindle anew",
                &[],
            );
        }
    }
}

impl Work for Worker {
    fn work(&mut self, _: u32) -> u32 {
        let now = self.clock.now_ns();
        self.listen(now);
        if let Some(line) = self.line(now) {
            line.advance(now);
            for _ in 0..MOST {
                if !self.speak(&line, now) {
                    break;
                }
            }
        }
        self.halt.flags.set_may_run(self.drive.may_run());
        let results = self.drive.results(now);
        self.tell();
        self.results.set(&results);
        self.steps.fetch_add(1, Relaxed);
        0
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.halt.last_stop();
    }
}

//! The core of the task: states, modes and jobs, without HAL.
//!
//! ```text
//!               open                run                    pause, M0, M1
//!  no program ────────▶ program ──────────▶ running job ───────────────▶ paused job
//!                          ▲   the end, M2, M30 │  ▲          resume, step   │
//!                          ├────────────────────┘  └─────────────────────────┤
//!                          │     at rest               abort, error, off     │
//!                          └──────────────── ending ◀────────────────────────┘
//! ```

mod check;
mod checking;
mod end;
mod entry;
mod function;
mod journal;
mod origin;
mod overrides;
mod pump;
mod read;
mod recover;
pub(crate) mod restart;
mod rules;
mod tool;
pub(crate) mod user;
mod values;
mod wait;

use crate::{
    convert::{Action, Converter},
    outside::{Order, Outside, Ticket},
};
use checking::Checking;
use hal_component::StopEpoch;
use hal_gcode::{Interpreter, Request, state::modal::MAX_SPINDLES};
use hal_job::{World, run};
use journal::Keeping;
use origin::{Origin, Tag, Undo};
use restart::Restart;
pub(crate) use rules::Rules;
use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::Arc,
};
use tool::Held;

/// Number of lines of MDI that can wait.
pub(crate) const MDI_LEN: usize = 10;
/// Reason for the end of a job that somebody has aborted.
const STOPPED: &str = "aborted";
/// Number of steps that the interpreter may be ahead.
const READ_AHEAD: usize = 256;

/// State of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Power {
    /// In e-stop.
    #[default]
    Estop,
    /// Out of e-stop, and off.
    Off,
    /// On.
    On,
}

/// Mode of the task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Jogs and homing.
    #[default]
    Manual,
    /// Programs.
    Auto,
    /// Single lines.
    Mdi,
}

impl Mode {
    /// Returns the name in commands and messages.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Manual => "manual",
            Self::Auto => "auto",
            Self::Mdi => "mdi",
        }
    }
}

/// State of the interpreter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Interpreting {
    /// No job.
    #[default]
    Idle,
    /// Reads a job.
    Reading,
    /// The job is paused.
    Paused,
    /// Waits for the machine: a probe, a tool, an input, the end of motion.
    Waiting,
}

/// Progress of the interpreter in a job.
#[derive(Clone, Debug, PartialEq)]
enum Reading {
    Lines,
    /// The interpreter waits for an answer; its calls so far are in the queue.
    Asked(Request),
    Ended,
}

/// A program or a line of MDI in execution.
#[derive(Clone, Debug)]
struct Job {
    is_program: bool,
    reading: Reading,
    ticket: Option<Ticket>,
    /// Stop epoch in which the job was given, or resumed last: its orders are of this epoch.
    given: StopEpoch,
    paused: bool,
    /// Pauses when a step of another line is next; the number of the line, once one has begun.
    stepping: Option<Option<u64>>,
    /// Pause was sent to motion.
    held: bool,
    /// Answer to the interpreter's question, if the machine's state does not have it.
    input: f64,
    questions: Vec<values::HalQuestion>,
    user_code: Result<(), String>,
    /// A function in Python is at work on its next step.
    is_stepping_function: bool,
    began: f64,
}

/// A step of the job with the line that it comes from.
#[derive(Clone, Debug)]
struct Entry {
    action: Action,
    origin: Origin,
}

/// An order that motion has taken and not finished.
#[derive(Clone, Debug)]
struct Flight {
    id: u64,
    origin: Origin,
}

/// The step in execution, which the following steps wait for.
#[derive(Clone, Debug, PartialEq)]
enum Waiting {
    Order(u64),
    Io(u64),
    Change { id: u64, tool: i32 },
    Dwell { until: f64 },
    Input { index: u32, analog: bool, mode: u8, until: f64, before: bool },
    Oriented { until: f64 },
    Program,
}

/// An abort in progress.
#[derive(Clone, Debug)]
struct Ending {
    /// True if motion has been stopped already: it needs no abort.
    is_stopped: bool,
    order: Option<u64>,
    sent: bool,
    origin: Option<Origin>,
}

/// A spindle at constant surface speed: machine units per minute, top speed, and the speed that was sent.
#[derive(Clone, Copy, Debug)]
struct Surface {
    speed: f64,
    top: f64,
    sent: f64,
}

/// An order or request of a command, whose result the command reports.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Asked {
    Order(u64),
    Io(u64),
}

/// The core of the task.
pub(crate) struct Core {
    pub(crate) world: World,
    pub(crate) interpreter: Interpreter,
    pub(crate) converter: Converter,
    pub(crate) mode: Mode,
    pub(crate) power: Power,
    pub(crate) program: Option<PathBuf>,
    pub(crate) optional_stop: bool,
    rules: Rules,
    job: Option<Job>,
    queue: VecDeque<Entry>,
    flight: VecDeque<Flight>,
    waiting: Option<Waiting>,
    /// The line of the step in execution, for messages and the state after an abort.
    current: Option<Origin>,
    ending: Option<Ending>,
    /// The request for the next tool.
    preparing: Option<u64>,
    pub(crate) held: Held,
    mdi: VecDeque<(Box<str>, StopEpoch, Ticket)>,
    /// The line of MDI that began last.
    mdi_text: Box<str>,
    /// Mode that comes back after lines of MDI from another mode.
    mode_before: Option<Mode>,
    asked: Vec<(Asked, Ticket)>,
    serial: u64,
    last_tag: Option<Arc<Tag>>,
    undo: Undo,
    restart: Restart,
    checking: Checking,
    keeping: Keeping,
    surface: [Option<Surface>; MAX_SPINDLES],
    /// Time since which a move waits for the spindle.
    at_speed_since: Option<f64>,
    pub(crate) feed: overrides::Feed,
    pub(crate) spindle_scale: [f64; MAX_SPINDLES],
    pub(crate) spindle_counts: [bool; MAX_SPINDLES],
    overriding: overrides::Orders,
    /// The last wait for an input ended without it.
    pub(crate) input_was_late: bool,
    /// Number of jobs that have ended, and of those that have failed.
    pub(crate) jobs: (u32, u32),
    /// Number of aborts, and of ends of the state on.
    pub(crate) stops: u32,
    /// Stop epoch of motion as it is known.
    seen: StopEpoch,
    /// Machine time of the current or last job in seconds.
    pub(crate) job_time: f64,
    /// The last message for the operator.
    pub(crate) message: Box<str>,
    pub(crate) messages: u32,
    /// Importance of the last message.
    pub(crate) message_level: crate::outside::Level,
}

impl Core {
    /// Returns the task of a machine, with the startup code of its INI file in force.
    ///
    /// # Errors
    /// The startup code has an error.
    pub(crate) fn new(mut world: World, rules: Rules) -> Result<Self, String> {
        world.machine.settings.task = true;
        let settings = world.machine.settings.clone();
        let mut interpreter = Interpreter::new(settings.clone(), world.machine.numbered.clone());
        run::start(&mut interpreter, &world)?;
        interpreter.state.numbered.record_changes();
        let held = Held::new(&world.machine, &mut interpreter);
        let mut converter = Converter::new(&settings, rules.change_position);
        converter.restart(&interpreter.state, [0.0; 9]);
        Ok(Self {
            world,
            interpreter,
            converter,
            mode: Mode::Manual,
            power: Power::Estop,
            program: None,
            optional_stop: true,
            rules,
            job: None,
            queue: VecDeque::new(),
            flight: VecDeque::new(),
            waiting: None,
            current: None,
            ending: None,
            preparing: None,
            held,
            mdi: VecDeque::new(),
            mdi_text: Box::default(),
            mode_before: None,
            asked: Vec::new(),
            serial: 0,
            last_tag: None,
            undo: Undo::default(),
            restart: Restart::default(),
            checking: Checking::default(),
            keeping: Keeping::default(),
            surface: [None; MAX_SPINDLES],
            at_speed_since: None,
            feed: overrides::Feed::default(),
            spindle_scale: [1.0; MAX_SPINDLES],
            spindle_counts: [true; MAX_SPINDLES],
            overriding: overrides::Orders::default(),
            input_was_late: false,
            jobs: (0, 0),
            stops: 0,
            seen: StopEpoch::default(),
            job_time: 0.0,
            message: Box::default(),
            messages: 0,
            message_level: crate::outside::Level::Info,
        })
    }

    /// Does at most `items` steps of work and returns their number.
    pub(crate) fn step(&mut self, out: &mut impl Outside, items: u32) -> u32 {
        if let Some(job) = &self.job {
            let now = out.now() - job.began;
            let runs = !self.flight.is_empty() && !job.paused;
            self.checking.pass(if runs { now - self.job_time } else { 0.0 }, self.unfinished().0);
            self.job_time = now;
        }
        self.watch(out);
        self.watch_tool(out);
        self.report(out);
        self.follow_surface(out);
        self.follow_overrides(out);
        if self.ending.is_some() {
            self.finish_ending(out);
            return 0;
        }
        self.advance_dry_run(out);
        self.advance_check(out);
        self.begin_mdi(out);
        self.restore_mode();
        let done = (0..items).take_while(|_| self.pump(out)).count();
        self.keep_journal(out);
        u32::try_from(done).unwrap_or(items)
    }

    /// Follows e-stop and the machine's state; a job ends when the machine goes off.
    fn watch(&mut self, out: &mut impl Outside) {
        let (io, motion) = (out.io(), out.motion());
        let power = match (io.estop.is_released(), motion.enabled) {
            (false, _) => Power::Estop,
            (true, false) => Power::Off,
            (true, true) => Power::On,
        };
        // Nothing moves in e-stop, whatever is wired.
        if power == Power::Estop && motion.enabled {
            drop(out.order(&Order::Disable, out.epoch()));
        }
        let is_stopped = self.see_stops(motion.epoch);
        let was = core::mem::replace(&mut self.power, power);
        if was == Power::On && power != Power::On {
            let is_estop = power == Power::Estop;
            let off = "the machine was switched off";
            let why = if is_estop { "the machine is in e-stop" } else { off };
            self.stops = self.stops.wrapping_add(1);
            self.mode = if self.job.is_some() { self.mode } else { Mode::Manual };
            return self.end_job(why, out);
        }
        if is_stopped {
            return self.obey_stop(motion.epoch, out);
        }
        self.obey_pause(motion.epoch);
        if self.job.is_some() && self.rules.needs_homing && !motion.all_homed {
            self.fail("a joint is no longer homed", out);
        }
    }

    /// Returns whether motion was stopped by somebody else since it was last asked.
    fn see_stops(&mut self, now: StopEpoch) -> bool {
        let is_stopped = self.seen.is_stopped_by(now);
        if is_stopped || self.seen.is_paused_by(now) {
            self.seen = now;
        }
        is_stopped
    }

    /// Motion was stopped: what was given before ends, and coolant and tool change with it.
    fn obey_stop(&mut self, now: StopEpoch, out: &mut impl Outside) {
        self.stops = self.stops.wrapping_add(1);
        if self.ending.is_some() {
            return;
        }
        let given = self.job.as_ref().map(|job| job.given).or_else(|| self.checking.given());
        if given.is_none_or(|given| given.is_stopped_by(now)) {
            self.end_all(STOPPED, true, out);
        }
    }

    /// Motion was paused: a job that was given before rests until it is resumed.
    fn obey_pause(&mut self, now: StopEpoch) {
        if let Some(job) = &mut self.job
            && job.given.is_paused_by(now)
        {
            (job.paused, job.held) = (true, true);
        }
    }

    /// Returns the epoch of the job's orders.
    fn job_epoch(&self, out: &impl Outside) -> StopEpoch {
        self.job.as_ref().map_or_else(|| out.epoch(), |job| job.given)
    }

    /// Returns whether a job is in execution or ending, or a program is checked before its start.
    pub(crate) fn is_busy(&self) -> bool {
        self.job.is_some() || self.ending.is_some() || self.checking.is_before_start()
    }

    /// Returns whether something is in execution or waits; between two lines of MDI that wait, nothing is in execution.
    pub(crate) fn has_work(&self) -> bool {
        self.is_busy() || !self.mdi.is_empty()
    }

    /// Returns the state of the interpreter.
    pub(crate) fn interpreting(&self) -> Interpreting {
        match &self.job {
            None if self.ending.is_some() => Interpreting::Waiting,
            None if self.checking.is_before_start() => Interpreting::Reading,
            None => Interpreting::Idle,
            Some(job) if job.paused => Interpreting::Paused,
            Some(job) if job.reading == Reading::Lines && self.waiting.is_none() => {
                Interpreting::Reading
            }
            Some(_) => Interpreting::Waiting,
        }
    }

    /// Returns the line in execution; 0 without one.
    pub(crate) fn line(&self) -> u32 {
        if self.awaited_tool().is_some() && self.waiting.is_none() {
            return self.queue.front().map_or(0, |entry| entry.origin.line);
        }
        let flight = self.flight.front().map(|f| f.origin.line);
        match (&self.waiting, &self.current) {
            (Some(_), Some(origin)) => origin.line,
            (_, Some(origin)) => flight.unwrap_or(origin.line),
            (_, None) => flight.unwrap_or(0),
        }
    }

    /// Returns the number of steps that wait in the task.
    pub(crate) fn queue_len(&self) -> usize {
        self.queue.len()
    }

    /// Tells the operator something.
    fn tell(&mut self, level: crate::outside::Level, text: &str, out: &mut impl Outside) {
        self.message = text.into();
        self.messages = self.messages.wrapping_add(1);
        self.message_level = level;
        out.say(level, text);
    }
}

/// Returns the name of a file without its folders.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

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

pub(crate) mod awaited;
mod check;
mod checking;
mod end;
mod ended;
mod entry;
mod function;
mod journal;
mod origin;
mod overrides;
mod pause;
mod progress;
mod pump;
mod read;
mod recover;
pub(crate) mod restart;
mod rules;
mod tool;
pub(crate) mod user;
mod values;
mod wait;
mod wait_record;
mod watch;

use crate::{
    convert::{Action, Converter},
    outside::{Outside, Ticket},
};
use checking::Checking;
use ended::{ESTOP, OFF, STOPPED};
pub(crate) use ended::{EndedBy, is_stop};
use hal_component::{StopEpoch, Wait};
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
    /// The reason of the pause.
    why_paused: Wait,
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

/// A line of MDI that waits.
#[derive(Clone, Debug)]
struct MdiLine {
    text: Box<str>,
    given: StopEpoch,
    ticket: Ticket,
    is_from_afar: bool,
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
    Change {
        id: u64,
        tool: i32,
    },
    Dwell {
        until: f64,
    },
    Input {
        index: u32,
        analog: bool,
        mode: u8,
        until: f64,
        before: bool,
    },
    Oriented {
        until: f64,
    },
    /// A program of the user with this code.
    Program(u16),
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
    /// The reset of the e-stop.
    Reset(u64),
    /// The order to go on after a pause.
    Resume(u64),
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
    mdi: VecDeque<MdiLine>,
    /// The line of MDI that began last.
    mdi_text: Box<str>,
    /// Mode that comes back after lines of MDI from another mode.
    mode_before: Option<Mode>,
    /// People elsewhere have given the command in execution.
    pub(crate) is_from_afar: bool,
    /// People elsewhere have begun the job, or the check before it.
    is_job_from_afar: bool,
    asked: Vec<(Asked, Ticket)>,
    /// Commands to switch on that wait for a reset of the e-stop.
    on_after_reset: Vec<(StopEpoch, Ticket)>,
    serial: u64,
    last_tag: Option<Arc<Tag>>,
    undo: Undo,
    restart: Restart,
    checking: Checking,
    keeping: Keeping,
    surface: [Option<Surface>; MAX_SPINDLES],
    /// Time since which a move waits for the spindle.
    at_speed_since: Option<f64>,
    waits: awaited::Waits,
    pub(crate) feed: overrides::Feed,
    pub(crate) spindle_scale: [f64; MAX_SPINDLES],
    pub(crate) spindle_counts: [bool; MAX_SPINDLES],
    overriding: overrides::Orders,
    /// The last wait for an input ended without it.
    pub(crate) input_was_late: bool,
    /// Number of jobs that have ended, and of those that have failed.
    pub(crate) jobs: (u32, u32),
    pub(crate) ended_by: EndedBy,
    /// The parameter file could not be written, which was told.
    is_unsaved: bool,
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
            is_from_afar: false,
            is_job_from_afar: false,
            asked: Vec::new(),
            on_after_reset: Vec::new(),
            serial: 0,
            last_tag: None,
            undo: Undo::default(),
            restart: Restart::default(),
            checking: Checking::default(),
            keeping: Keeping::default(),
            surface: [None; MAX_SPINDLES],
            at_speed_since: None,
            waits: awaited::Waits::default(),
            feed: overrides::Feed::default(),
            spindle_scale: [1.0; MAX_SPINDLES],
            spindle_counts: [true; MAX_SPINDLES],
            overriding: overrides::Orders::default(),
            input_was_late: false,
            jobs: (0, 0),
            ended_by: EndedBy::default(),
            is_unsaved: false,
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
        let done = self.work(out, items);
        self.follow_wait(out);
        done
    }

    fn work(&mut self, out: &mut impl Outside, items: u32) -> u32 {
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

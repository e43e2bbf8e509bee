//! Everything outside the core: motion, iocontrol, files, the clock.

use crate::error::UserProgramError;
use hal_component::{IoRequest, IoState, StopEpoch};
use hal_gcode::{Environment, Numbered, State, tool::ToolTable};
use hal_job::{journal::Record, spindle::Spindle};
use std::path::Path;

/// Speed of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Speed {
    /// As fast as the limits allow.
    Rapid,
    /// Machine units per second along the path.
    Feed(f64),
}

/// Path control at the end of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PathEnd {
    /// Rests at the end.
    Stop,
    /// Stays on the path.
    Exact,
    /// Leaves the path by at most this distance; infinity without one.
    Blend(f64),
}

/// Travel per turn of a spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pitch {
    pub(crate) spindle: u8,
    /// Machine units per turn.
    pub(crate) travel: f64,
    /// The velocity follows the spindle, without its phase.
    pub(crate) velocity_mode: bool,
    /// The spindle is at constant surface speed.
    pub(crate) is_at_surface: bool,
}

/// The shape of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    Line,
    /// An arc counterclockwise around its normal, with additional full turns.
    Arc {
        center: [f64; 3],
        normal: [f64; 3],
        clockwise: bool,
        turns: u32,
    },
    /// A probe move; it ends where the probe loses its contact if `away`.
    Probe {
        away: bool,
        must: bool,
    },
    /// A rigid tap, with a factor for the speed of its way back.
    Tap {
        retract_scale: f64,
    },
}

/// A move to a pose in machine coordinates and units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Move {
    pub(crate) to: [f64; 9],
    pub(crate) shape: Shape,
    pub(crate) speed: Speed,
    pub(crate) end: PathEnd,
    /// Distance within which short lines join.
    pub(crate) cam_tolerance: f64,
    pub(crate) pitch: Option<Pitch>,
    pub(crate) line: u32,
}

/// An order to motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Order {
    Enable,
    Disable,
    /// A joint, or all.
    Home(Option<u32>),
    Abort,
    Pause,
    Resume,
    Step,
    Move(Move),
    /// Turns per minute, negative in reverse.
    Spindle {
        spindle: u8,
        speed: f64,
    },
    SpindleScale {
        spindle: u8,
        scale: f64,
    },
    Orient {
        spindle: u8,
        degrees: f64,
        mode: u8,
    },
    /// Overrides of feeds and of rapid moves, as far as they change.
    FeedScale {
        feed: Option<f64>,
        rapid: Option<f64>,
    },
    AdaptiveFeed(bool),
    FeedHold(bool),
    Digital {
        index: u32,
        on: bool,
        with_motion: bool,
    },
    Analog {
        index: u32,
        value: f64,
        with_motion: bool,
    },
    ToolOffset([f64; 9]),
}

/// Rights of a program of the user at the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rights {
    /// The rights of the machine's owner.
    Owner,
    /// The rights of people elsewhere, who have begun its job.
    FromAfar,
}

/// Reason for which an order was not accepted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Refusal {
    /// There is no room now.
    Full,
    /// The reason.
    Why(Box<str>),
}

/// Progress of an order or request.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Progress {
    Pending,
    Done,
    Failed(String),
}

/// State of motion in a cycle. Positions are in machine units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MotionState {
    /// Number of the cycle; 0 before the first one.
    pub(crate) cycle: u64,
    pub(crate) enabled: bool,
    /// Nothing moves, and nothing waits to move.
    pub(crate) in_position: bool,
    pub(crate) all_homed: bool,
    pub(crate) velocity: f64,
    pub(crate) queue: u32,
    pub(crate) pose: [f64; 9],
    pub(crate) probe_found: bool,
    pub(crate) probe_measured: [f64; 9],
    pub(crate) digital_in: u64,
    pub(crate) analog_in: [f64; 8],
    pub(crate) at_speed: bool,
    pub(crate) feed_override: f64,
    pub(crate) rapid_override: f64,
    pub(crate) spindle_override: [f64; 8],
    /// Stop epoch of the cycle.
    pub(crate) epoch: StopEpoch,
    /// Wait of motion: number of a [`hal_component::Wait`], its object, and the machine time since which it lasts.
    pub(crate) wait: u32,
    pub(crate) wait_number: i32,
    pub(crate) wait_since: f64,
    /// The wait is a ramp, which ends by itself.
    pub(crate) wait_ends: bool,
    /// Spindles that were stopped after the program turned them, and those that are inhibited; a bit for each.
    pub(crate) spindles_stopped: u32,
    pub(crate) spindles_inhibited: u32,
    /// Distance travelled along the move in execution, and to its end.
    pub(crate) travelled: f64,
    pub(crate) to_go: f64,
}

/// Importance of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    Error,
    /// Text of a program for the operator.
    Notice,
    Info,
}

/// A user's command that waits for its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Ticket(pub(crate) u64);

/// A file that a program writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FileKind {
    /// `LOGOPEN`, `LOGAPPEND`, `LOG`.
    Log,
    /// `PROBEOPEN`: a line for each probe move that trips.
    Probe,
}

/// A step with a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FileAction {
    Open {
        kind: FileKind,
        name: Box<str>,
        append: bool,
    },
    /// Nothing happens without an open file.
    Line(FileKind, Box<str>),
    Close(FileKind),
}

/// Everything outside the core.
pub(crate) trait Outside {
    /// Returns machine time in seconds.
    fn now(&self) -> f64;
    /// Returns the state of motion in its latest cycle.
    fn motion(&self) -> MotionState;
    /// Returns the state of iocontrol.
    fn io(&self) -> IoState;
    /// Returns the stop epoch of now, which may be younger than that of the latest cycle.
    fn epoch(&self) -> StopEpoch;
    /// Sends an order to motion that was given in a stop epoch, and returns its number. After a stop since then, motion
    /// refuses it.
    fn order(&mut self, order: &Order, given: StopEpoch) -> Result<u64, Refusal>;
    /// Returns how far an order has come.
    fn ordered(&mut self, id: u64) -> Progress;
    /// Sends a request to iocontrol; `None` if it takes none now.
    fn request(&mut self, request: IoRequest) -> Option<u64>;
    /// Returns how far a request has come.
    fn requested(&mut self, id: u64) -> Progress;
    /// Asks for the value of a pin, parameter or signal, and returns the number of the question.
    fn ask_value(&mut self, name: &str) -> u64;
    /// Takes the answer to such a question, once: `None` while there is none, `Some(None)` if nothing has the name.
    fn take_value(&mut self, question: u64) -> Option<Option<f64>>;
    /// Begins a user's program.
    fn begin_program(
        &mut self,
        code: u16,
        p: f64,
        q: f64,
        rights: Rights,
    ) -> Result<(), UserProgramError>;
    /// Returns how far the user's program has come.
    fn program(&mut self) -> Progress;
    /// Ends the user's program.
    fn end_program(&mut self);
    /// Begins the next step of the function in Python that is the innermost level of a state.
    fn begin_function(&mut self, state: &State, env: &dyn Environment) -> Result<(), String>;
    /// Returns how far that step has come.
    fn function(&mut self) -> hal_remap::Progress;
    /// Ends the functions in progress.
    fn end_functions(&mut self);
    /// Tells the operator something.
    fn say(&mut self, level: Level, text: &str);
    /// Reports how a command ended.
    fn finish(&mut self, ticket: Ticket, result: Result<(), String>);
    /// Writes the parameter file.
    fn save_parameters(&mut self, numbered: &Numbered) -> Result<(), String>;
    /// Writes a record of the journal; the begin of a job begins a new journal.
    fn journal(&mut self, record: &Record) -> Result<(), String>;
    /// Reads the journal.
    fn read_journal(&self) -> Result<Vec<u8>, String>;
    /// Opens, writes or closes a file of the program, whose own file is stated.
    fn file(&mut self, action: &FileAction, program: Option<&Path>) -> Result<(), String>;
    /// Writes the tool table.
    fn save_tools(&mut self, tools: &ToolTable) -> Result<(), String>;
    /// Writes the record of the tool in the spindle, behind the record before.
    fn save_spindle(&mut self, before: Spindle, now: Spindle) -> Result<(), String>;
}

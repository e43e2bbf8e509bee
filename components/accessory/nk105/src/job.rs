//! A G-code program as steps of a job, in the coordinates of the work.

use core::fmt;
use hal_gcode::{
    Call, Environment, Interpreter, Numbered, Settings,
    axis::{AxisMask, Position},
    canon::Direction,
    error::Problem,
    tool::Tool,
};
use hal_job::{
    run::{Answers, step},
    way::{Kind, Way},
};
use std::sync::Arc;

/// Largest number of steps of a job.
pub const MOST_STEPS: usize = 2_000_000;

/// Step of a job.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum JobStep {
    /// A straight line to a place in millimetres, at a feed in mm/s; 0 is a rapid.
    Line([f64; 3], f64),
    /// Rest for some seconds.
    Dwell(f64),
    /// Change to a tool.
    Tool(i32),
    /// Spindle on or off.
    Spindle(bool),
    /// Pause until RUN is pressed.
    Pause,
}

/// Reason why a program is no job.
#[derive(Clone, PartialEq, Debug)]
pub enum WrongJob {
    /// The program has an error: the line, and the error's text.
    Program(u32, Box<str>),
    /// A statement that the controller does not know: the line, and its name.
    Unsupported(u32, &'static str),
    /// The program makes too many steps.
    Long,
    /// The program stays within one line without end.
    Endless(u32),
    /// A place that the machine does not reach: the line of the step.
    Travel(u32),
}

impl WrongJob {
    /// Returns the line; 0 if it is about the whole program.
    #[must_use]
    pub const fn line(&self) -> u32 {
        match self {
            Self::Program(line, _)
            | Self::Unsupported(line, _)
            | Self::Endless(line)
            | Self::Travel(line) => *line,
            Self::Long => 0,
        }
    }
}

impl fmt::Display for WrongJob {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Program(_, text) => f.write_str(text),
            Self::Unsupported(line, name) => {
                write!(f, "line {line}: the controller does not know {name}")
            }
            Self::Long => write!(f, "the program makes more than {MOST_STEPS} steps"),
            Self::Endless(line) => write!(f, "line {line}: the program does not come to an end"),
            Self::Travel(line) => {
                write!(f, "line {line}: the place is beyond the machine's travel")
            }
        }
    }
}

/// World without files, with a tool of no length for every number.
struct Empty;

impl Environment for Empty {
    fn open(&self, _: &str) -> Option<hal_gcode::Text> {
        None
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        Some(Tool { number, pocket: number, ..Tool::default() })
    }
}

/// Reads a program. `origin` is the work's zero in machine coordinates, `travel` the reach of each axis to either side.
///
/// # Errors
/// The first line that is wrong, that the controller does not know, or whose place is beyond the travel.
pub fn read(text: &[u8], origin: [f64; 3], travel: f64) -> Result<Vec<JobStep>, WrongJob> {
    let settings = Settings { axes: AxisMask::XYZABC, ..Settings::default() };
    let mut it = Interpreter::new(settings, Numbered::default());
    it.synchronise(Position::default());
    it.load("job", Arc::new(text.to_vec()));
    let mut way = Way::new(it.state.frame, Position::default());
    let mut reader = JobReader { steps: Vec::new(), feed: 0.0, origin, travel };
    let mut calls = Vec::new();
    // Calls without a step, such as F, are no progress either.
    let (mut idle, mut line) = (0_u32, 0);
    loop {
        let going =
            step(&mut it, &Empty, Answers { probe_trips: false, functions: None }, &mut calls);
        let steps = reader.steps.len();
        if idle > 1_000_000 {
            return Err(WrongJob::Endless(line));
        }
        for issued in calls.drain(..) {
            line = issued.line;
            reader.call(&issued.call, &mut way, it.state.frame.unit.millimetres(), line)?;
        }
        idle = if reader.steps.len() == steps { idle + 1 } else { 0 };
        match going {
            Ok(true) => {}
            Ok(false) => return Ok(reader.steps),
            // Programs of this kind may end with their file.
            Err(error) if matches!(error.problem, Problem::NoProgramEnd) => {
                return Ok(reader.steps);
            }
            Err(error) => {
                return Err(WrongJob::Program(error.place.line, error.to_string().into()));
            }
        }
    }
}

/// Steps so far.
struct JobReader {
    steps: Vec<JobStep>,
    /// Feed in mm/s.
    feed: f64,
    origin: [f64; 3],
    travel: f64,
}

impl JobReader {
    fn call(&mut self, call: &Call, way: &mut Way, mm: f64, line: u32) -> Result<(), WrongJob> {
        let unknown = |name| Err(WrongJob::Unsupported(line, name));
        match call {
            Call::NurbsFeed { .. } => unknown("splines"),
            Call::StraightProbe { .. } => unknown("a probe"),
            Call::RigidTap { .. } => unknown("a rigid tap"),
            Call::StartSpeedFeedSync { .. } | Call::SetFeedMode { per_revolution: true, .. } => {
                unknown("a feed per revolution")
            }
            Call::SetFeedRate(feed) => {
                self.feed = feed * mm / 60.0;
                Ok(())
            }
            Call::Dwell(seconds) => self.push(JobStep::Dwell(*seconds)),
            Call::ChangeTool(number) => self.push(JobStep::Tool(*number)),
            Call::TurnSpindle { direction, .. } => {
                self.push(JobStep::Spindle(*direction != Direction::Stopped))
            }
            Call::ProgramStop => self.push(JobStep::Pause),
            _ => self.moves(call, way, line),
        }
    }

    fn moves(&mut self, call: &Call, way: &mut Way, line: u32) -> Result<(), WrongJob> {
        let mut result = Ok(());
        let feed = self.feed;
        way.follow(call, &mut |kind, place| {
            if result.is_err() {
                return;
            }
            let to = [place.x, place.y, place.z];
            let mut reached = to.iter().zip(self.origin).map(|(a, b)| a + b);
            let is_within = reached.all(|p| -self.travel <= p && p <= self.travel);
            let turns = place.a != 0.0 || place.b != 0.0 || place.c != 0.0;
            result = match (is_within, turns) {
                (_, true) => Err(WrongJob::Unsupported(line, "A, B and C")),
                (false, false) => Err(WrongJob::Travel(line)),
                (true, false) => {
                    let speed = if kind == Kind::Rapid { 0.0 } else { feed };
                    self.push(JobStep::Line(to, speed))
                }
            };
        });
        result
    }

    fn push(&mut self, step: JobStep) -> Result<(), WrongJob> {
        if self.steps.len() >= MOST_STEPS {
            return Err(WrongJob::Long);
        }
        self.steps.push(step);
        Ok(())
    }
}

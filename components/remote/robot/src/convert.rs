//! G-code programs as lines of the protocol.

use crate::{Command, Outside, Volume, Zero};
use hal_gcode::{
    Answer, Call, Environment, Error, Interpreter, Numbered, Request, Settings, Step,
    axis::{AxisMask, Position},
    canon::{Frame, Plane},
    error::Problem,
    tool::Tool,
};
use libm::{atan2, ceil, cos, hypot, sin};
use std::{fmt, sync::Arc};

/// Largest angle of an arc that becomes one move, in degrees.
const STEP: f64 = 1.0;
/// Position of the tool before the program, in the part frame.
const BEGIN: [f64; 3] = [0.0, 0.0, 10.0];
/// Slowest cutting speed, in millimetres per second.
const SLOWEST: f64 = 0.001;
/// Largest number of lines to the robot.
const MAX_RECORDS: usize = 5_000_000;

/// Line to the robot, and the line of the program that it comes from.
#[derive(Clone, PartialEq, Debug)]
pub struct Record {
    /// Line of the program, from 1.
    pub line: u32,
    /// Text of that line; empty for further moves of the same line.
    pub text: String,
    /// Line to the robot.
    pub command: Command,
}

/// Reason why a program cannot be run.
#[derive(Clone, PartialEq, Debug)]
pub enum Failed {
    /// The program has an error; its text names the place.
    Program(Box<str>),
    /// A statement that the robot cannot follow: the line, and its name.
    Unsupported(u32, &'static str),
    /// A point that the tool must not go to: the line, the point in the part frame, the reason.
    Outside(u32, [f64; 3], Outside),
    /// The program makes too many lines.
    TooLong,
    /// The program stays within one line without end.
    Endless,
}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Program(text) => f.write_str(text),
            Self::Unsupported(line, name) => {
                write!(f, "line {line}: the robot cannot follow {name}")
            }
            Self::Outside(line, [x, y, z], why) => {
                write!(f, "line {line}: X{x:.3} Y{y:.3} Z{z:.3} is {why}")
            }
            Self::TooLong => write!(f, "the program makes more than {MAX_RECORDS} lines"),
            Self::Endless => f.write_str("the program does not come to an end"),
        }
    }
}

/// World without files, with a tool of no length for every number.
struct Bare;

impl Environment for Bare {
    fn open(&self, _: &str) -> Option<hal_gcode::Text> {
        None
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        Some(Tool { number, pocket: number, ..Tool::default() })
    }
}

/// Converter on its way through a program.
struct Converter<'a> {
    volume: &'a Volume,
    zero: &'a Zero,
    top: f64,
    frame: Frame,
    at: [f64; 3],
    lines: Vec<&'a [u8]>,
    records: Vec<Record>,
    warnings: Vec<String>,
    feed: f64,
    sent: f64,
    last_line: u32,
}

/// Converts a program. `top` is the operator's cutting speed in millimetres per second. Every point is checked.
///
/// # Errors
/// The first line that the robot cannot follow, or whose tool path leaves the work volume.
pub fn convert(
    text: &[u8],
    volume: &Volume,
    zero: &Zero,
    top: f64,
) -> Result<(Vec<Record>, Vec<String>), Failed> {
    let settings = Settings { axes: AxisMask::XYZABC, ..Settings::default() };
    let mut it = Interpreter::new(settings, Numbered::default());
    let mut begin = Position::default();
    (begin.x, begin.y, begin.z) = (BEGIN[0], BEGIN[1], BEGIN[2]);
    it.synchronise(begin);
    it.load("program", Arc::new(text.to_vec()));
    let mut converter = Converter {
        volume,
        zero,
        top,
        frame: it.state.frame,
        at: BEGIN,
        lines: text.split(|b| *b == b'\n').collect(),
        records: Vec::new(),
        warnings: Vec::new(),
        feed: f64::INFINITY,
        sent: 0.0,
        last_line: 0,
    };
    let mut calls = Vec::new();
    let mut idle = 0_u32;
    loop {
        let mut step = it.next(&Bare, &mut calls);
        idle = if calls.is_empty() { idle + 1 } else { 0 };
        if idle > 1_000_000 {
            return Err(Failed::Endless);
        }
        loop {
            // An answer makes calls too, and may end the program.
            for issued in calls.drain(..) {
                converter.call(&issued.call, issued.line)?;
            }
            match step {
                Ok(Step::Line) => break,
                Ok(Step::Ended) => return Ok((converter.records, converter.warnings)),
                Ok(Step::Ask(request)) => {
                    let answer = answer(&request).ok_or(Failed::Unsupported(
                        converter.last_line,
                        "a probe, an input or a user's program",
                    ))?;
                    step = it.answer(&answer, &Bare, &mut calls);
                }
                // Programs of this kind end with their file.
                Err(Error { problem: Problem::NoProgramEnd, .. }) => {
                    return Ok((converter.records, converter.warnings));
                }
                Err(error) => return Err(Failed::Program(error.to_string().into())),
            }
        }
    }
}

/// Returns the answer to a question; `None` to those that need a machine.
const fn answer(request: &Request) -> Option<Answer> {
    match request {
        Request::ToolChange { .. } => Some(Answer::ToolChange { position: None }),
        _ => None,
    }
}

impl Converter<'_> {
    fn call(&mut self, call: &Call, line: u32) -> Result<(), Failed> {
        self.frame.apply(call);
        self.last_line = line;
        match call {
            Call::StraightTraverse(end) => {
                let end = self.place(*end, line)?;
                self.go(end, true, line)
            }
            Call::StraightFeed(end) => {
                let end = self.place(*end, line)?;
                self.go(end, false, line)
            }
            Call::ArcFeed { plane: Plane::Xy, end, centre_first, centre_second, turns } => {
                self.arc(*end, (*centre_first, *centre_second), *turns, line)
            }
            Call::ArcFeed { .. } => Err(Failed::Unsupported(line, "arcs outside G17")),
            Call::NurbsFeed { .. } => Err(Failed::Unsupported(line, "splines")),
            Call::StraightProbe { .. } => Err(Failed::Unsupported(line, "a probe")),
            Call::RigidTap { .. } => Err(Failed::Unsupported(line, "a tap")),
            Call::StartSpeedFeedSync { .. } | Call::SetFeedMode { per_revolution: true, .. } => {
                Err(Failed::Unsupported(line, "a feed per revolution"))
            }
            Call::SetFeedRate(feed) => {
                self.feed = feed * self.frame.unit.millimetres() / 60.0;
                Ok(())
            }
            Call::UseToolLengthOffset(_) => self.warn(line, "the tool's length has no effect"),
            Call::ChangeTool(_) => self.warn(line, "the tool is changed by hand"),
            Call::TurnSpindle { .. } => self.warn(line, "the spindle is turned on and off by hand"),
            _ => Ok(()),
        }
    }

    fn warn(&mut self, line: u32, text: &str) -> Result<(), Failed> {
        if self.warnings.len() < 1000 {
            self.warnings.push(format!("line {line}: {text}"));
        }
        Ok(())
    }

    /// Returns a position of the program in the part frame.
    fn place(&self, position: Position, line: u32) -> Result<[f64; 3], Failed> {
        let p = self.frame.machine_mm(position);
        if p.a != 0.0 || p.b != 0.0 || p.c != 0.0 {
            return Err(Failed::Unsupported(line, "A, B and C"));
        }
        Ok([p.x, p.y, p.z])
    }

    /// Goes to a point of the part frame, if that is another one.
    fn go(&mut self, to: [f64; 3], is_rapid: bool, line: u32) -> Result<(), Failed> {
        if to == self.at {
            return Ok(());
        }
        let point = Volume::robot(self.zero, to);
        self.volume.check(point).map_err(|why| Failed::Outside(line, to, why))?;
        if !is_rapid {
            let speed = f64::max(SLOWEST, f64::min(self.feed, self.top));
            if speed != self.sent {
                self.push(Command::Speed(speed), line)?;
                self.sent = speed;
            }
        }
        self.at = to;
        self.push(if is_rapid { Command::Rapid(to) } else { Command::Cut(to) }, line)
    }

    fn push(&mut self, command: Command, line: u32) -> Result<(), Failed> {
        if self.records.len() >= MAX_RECORDS {
            return Err(Failed::TooLong);
        }
        let is_first = self.records.last().is_none_or(|r| r.line != line);
        let text = if is_first { self.line(line) } else { String::new() };
        self.records.push(Record { line, text, command });
        Ok(())
    }

    /// Returns a line of the program as text.
    fn line(&self, line: u32) -> String {
        let index = usize::try_from(line).unwrap_or(0).wrapping_sub(1);
        let text = self.lines.get(index).copied().unwrap_or_default();
        String::from_utf8_lossy(text).trim_end().to_owned()
    }

    /// Goes along an arc in equal angles of at most a degree; the last point is the end itself.
    fn arc(
        &mut self,
        end: Position,
        centre: (f64, f64),
        turns: i32,
        line: u32,
    ) -> Result<(), Failed> {
        let start = self.frame.program(Position::default());
        let to = self.place(end, line)?;
        let mut middle = start;
        (middle.x, middle.y, middle.z) = (centre.0, centre.1, end.z);
        let centre = self.place(middle, line)?;
        let from = self.at;
        let out = |p: &[f64; 3]| (p[0] - centre[0], p[1] - centre[1]);
        let (a, b) = (out(&from), out(&to));
        let direction = if turns < 0 { -1.0 } else { 1.0 };
        let begin = atan2(a.1, a.0);
        let mut sweep = direction * (atan2(b.1, b.0) - begin);
        while sweep <= 1e-9 {
            sweep += core::f64::consts::TAU;
        }
        sweep += core::f64::consts::TAU * f64::from(turns.unsigned_abs().saturating_sub(1));
        let (r0, r1) = (hypot(a.0, a.1), hypot(b.0, b.1));
        let count = ceil(sweep.to_degrees() / STEP - 1e-9).max(1.0);
        let mut n = 1.0;
        while n < count {
            let part = n / count;
            let angle = begin + direction * sweep * part;
            let radius = r0 + (r1 - r0) * part;
            let z = from[2] + (to[2] - from[2]) * part;
            self.go(
                [centre[0] + radius * cos(angle), centre[1] + radius * sin(angle), z],
                false,
                line,
            )?;
            n += 1.0;
        }
        self.go(to, false, line)
    }
}

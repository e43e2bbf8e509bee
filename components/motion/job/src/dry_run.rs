//! The dry run: a program as far as one of its lines, without its machine.
//!
//! A start in the middle of a program needs the state that the lines before it make. The dry run computes it with
//! the interpreter that also runs the program. What only the machine knows (a probe, an input, a value of HAL) comes
//! from the record of an earlier run; without one, the dry run ends there with a refusal.

use crate::{
    effects::{Effects, Outputs},
    refusal::{LineBegin, Refusal, Series, Unknown},
    world::World,
};
use core::cell::Cell;
use hal_gcode::{
    Answer, Environment, Interpreter, Issued, Request, State, Step, Text,
    axis::{Axis, Position},
    error::Place,
    tool::{Tool, ToolTable},
};
use std::collections::VecDeque;

/// Number of lines behind the place in which its repetitions are counted.
const COUNTED_LINES: u64 = 200_000;
/// Number of lines behind a refused place in which the next possible one is searched.
const NEXT_LINES: u64 = 10_000;

/// The place of a start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A line of the main program, or of the file of a subroutine, that is reached for this time, from 1.
    Line {
        /// The file of a subroutine; `None` for the main program.
        file: Option<Box<str>>,
        /// The line, from 1.
        line: u32,
        /// The number of the time.
        pass: u32,
    },
    /// The line before which this number of lines has run.
    Number(u64),
}

/// The state of a program before one of its lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The state of the interpreter.
    pub state: State,
    /// The line.
    pub begin: LineBegin,
    /// The lines of the calls in progress, the outermost first.
    pub calls: Vec<Place>,
    /// Number of the time at which this line is reached, and number of times that are known.
    pub pass: (u32, u32),
    /// The end of the program was not reached while the times were counted: there may be more.
    pub more: bool,
    /// The effects of the lines before it.
    pub effects: Effects,
}

/// Rules of the machine for the answers that it need not give.
#[derive(Clone, Debug, Default)]
pub struct Given {
    /// Place for tool changes in millimetres; axes without a coordinate stay where they are.
    pub change_position: Option<[Option<f64>; 9]>,
    /// Answers of an earlier run, in their order.
    pub answers: VecDeque<Answer>,
    /// Outputs that the program has set before its begin.
    pub outputs: Outputs,
    /// The tool table of an earlier run, if it is not that of the world.
    pub tools: Option<ToolTable>,
}

/// A dry run on its way.
pub struct DryRun {
    interpreter: Interpreter,
    target: Target,
    main: Box<str>,
    given: Given,
    seen: u32,
    /// The last line from which a start is possible.
    good: Option<LineBegin>,
    effects: Effects,
    found: Option<Box<Found>>,
    refused: Option<Refusal>,
    /// Lines that are still searched behind the place.
    rest: u64,
    calls: Vec<Issued>,
}

/// Facts of the world, with a note that the program has asked for one that is not known.
struct Asked<'a> {
    world: &'a World,
    tools: Option<&'a ToolTable>,
    hal: Cell<bool>,
}

impl Environment for Asked<'_> {
    fn open(&self, name: &str) -> Option<Text> {
        self.world.open(name)
    }
    fn tool(&self, number: i32) -> Option<Tool> {
        match self.tools {
            Some(tools) => tools.find(number).cloned(),
            None => self.world.tool(number),
        }
    }
    fn ini(&self, section: &str, key: &str) -> Option<f64> {
        self.world.ini(section, key)
    }
    fn hal(&self, name: &str) -> Option<f64> {
        let value = self.world.hal(name);
        self.hal.set(self.hal.get() || value.is_none());
        value
    }
    fn user_code(&self, code: u16) -> bool {
        self.world.user_code(code)
    }
}

impl DryRun {
    /// Returns the dry run of a program that this interpreter has loaded.
    pub fn new(interpreter: Interpreter, target: Target, given: Given) -> Self {
        let effects = Effects { outputs: given.outputs.clone(), ..Effects::default() };
        let main = interpreter.state.levels.first().map(|l| l.file.clone()).unwrap_or_default();
        Self {
            interpreter,
            target,
            main,
            given,
            seen: 0,
            good: None,
            effects,
            found: None,
            refused: None,
            rest: 0,
            calls: Vec::new(),
        }
    }

    /// Runs at most `lines` lines. Returns the state before the place once it is found, and `None` before.
    ///
    /// # Errors
    /// A start there is not possible; the reason.
    pub fn advance(&mut self, world: &World, lines: u32) -> Result<Option<Found>, Refusal> {
        for _ in 0..lines {
            let here = self.next_line();
            if self.found.is_some() || self.refused.is_some() {
                if self.look_behind(&here) {
                    return self.result();
                }
            } else {
                self.look(&here);
            }
            match self.step(world) {
                Ok(true) => {}
                _ if self.found.is_some() || self.refused.is_some() => return self.result(),
                Ok(false) => {
                    let (file, line) = self.wanted();
                    return Err(Refusal::NotReached { file, line, times: self.seen });
                }
                Err(refusal) => return Err(refusal),
            }
        }
        Ok(None)
    }

    /// Returns the interpreter, in the state of the place.
    pub fn into_interpreter(mut self, found: &Found) -> Interpreter {
        self.interpreter.state = found.state.clone();
        self.interpreter
    }

    fn result(&mut self) -> Result<Option<Found>, Refusal> {
        if let Some(refusal) = self.refused.take() {
            return Err(refusal);
        }
        let seen = self.seen;
        Ok(self.found.take().map(|mut found| {
            found.pass.1 = seen.max(found.pass.0);
            *found
        }))
    }

    /// Returns the line that would run next.
    fn next_line(&self) -> LineBegin {
        let state = &self.interpreter.state;
        let level = state.levels.last();
        LineBegin {
            number: state.lines_run,
            file: level.map(|l| l.file.clone()).unwrap_or_default(),
            line: level.map_or(0, |l| l.cursor.line + 1),
        }
    }

    fn wanted(&self) -> (Box<str>, u32) {
        match &self.target {
            Target::Line { file, line, .. } => {
                (file.clone().unwrap_or_else(|| self.main.clone()), *line)
            }
            Target::Number(_) => (self.main.clone(), 0),
        }
    }

    /// Tells whether a line is one of the target's times.
    fn is_wanted(&self, here: &LineBegin) -> bool {
        match &self.target {
            Target::Line { file, line, .. } => {
                let name = file.as_deref().unwrap_or(&self.main);
                let is_same = *here.file == *name || *here.file == *name.trim_end_matches(".ngc");
                here.line == *line && is_same
            }
            Target::Number(number) => here.number == *number,
        }
    }

    /// Notes a line from which a start is possible, and the place itself.
    fn look(&mut self, here: &LineBegin) {
        let state = &self.interpreter.state;
        let middle = middle(state);
        if middle.is_none() {
            self.good = Some(here.clone());
        }
        if !self.is_wanted(here) {
            return;
        }
        self.seen += 1;
        if let Target::Line { pass, .. } = self.target
            && self.seen != pass
        {
            return;
        }
        if let Some(of) = middle {
            let place = self.place(here);
            self.refused = Some(Refusal::Middle { place, of, from: self.good.clone(), next: None });
            self.rest = NEXT_LINES;
            return;
        }
        let mut calls = self.interpreter.places();
        calls.pop();
        self.found = Some(Box::new(Found {
            state: state.clone(),
            begin: here.clone(),
            calls,
            pass: (self.seen, self.seen),
            more: false,
            effects: self.effects.clone(),
        }));
        // A number names one time.
        self.rest = if matches!(self.target, Target::Line { .. }) { COUNTED_LINES } else { 0 };
    }

    /// Counts further times of a found place, or searches the next possible line. Returns whether this has ended.
    fn look_behind(&mut self, here: &LineBegin) -> bool {
        if let Some(Refusal::Middle { next, .. }) = &mut self.refused
            && middle(&self.interpreter.state).is_none()
        {
            *next = Some(here.clone());
            return true;
        }
        let is_place = self.found.as_ref().is_some_and(|f| f.begin.number == here.number);
        self.seen += u32::from(!is_place && self.found.is_some() && self.is_wanted(here));
        if self.rest == 0 {
            if let (Some(found), Target::Line { .. }) = (&mut self.found, &self.target) {
                found.more = true;
            }
            return true;
        }
        self.rest -= 1;
        false
    }

    fn place(&self, here: &LineBegin) -> Place {
        Place { file: here.file.clone(), line: here.line, column: 0 }
    }

    /// Runs a line with its questions. Returns false at the end of the program.
    fn step(&mut self, world: &World) -> Result<bool, Refusal> {
        let tools = self.given.tools.take();
        let asked = Asked { world, tools: tools.as_ref(), hal: Cell::new(false) };
        let mut calls = core::mem::take(&mut self.calls);
        calls.clear();
        let mut result = self.interpreter.next(&asked, &mut calls);
        while let Ok(Step::Ask(request)) = &result {
            let answer = self.answer(request)?;
            result = self.interpreter.answer(&answer, &asked, &mut calls);
        }
        for issued in &calls {
            self.effects.note(issued);
        }
        // Nothing takes the changes of a dry run back.
        drop(self.interpreter.state.numbered.take_changes());
        self.calls = calls;
        let hal = asked.hal.get();
        self.given.tools = tools;
        match result {
            Ok(step) => Ok(step != Step::Ended),
            Err(error) if hal => Err(Refusal::Unknown { place: error.place, what: Unknown::Hal }),
            Err(error) => Err(Refusal::Program(Box::new(error))),
        }
    }

    fn answer(&mut self, request: &Request) -> Result<Answer, Refusal> {
        if let Some(answer) = self.given.answers.pop_front() {
            return Ok(answer);
        }
        let state = &self.interpreter.state;
        let unknown = |what| {
            let file = state.levels.last().map(|l| l.file.clone()).unwrap_or_default();
            Err(Refusal::Unknown { place: Place { file, line: state.line, column: 0 }, what })
        };
        match request {
            Request::Probe => unknown(Unknown::Probe),
            Request::Input { .. } => unknown(Unknown::Input),
            Request::UserCode { .. } => Ok(Answer::Done),
            Request::ToolChange { .. } => Ok(Answer::ToolChange {
                position: self.given.change_position.map(|stated| {
                    let mut at = state.frame.machine_mm(state.position);
                    for (axis, place) in Axis::ALL.into_iter().zip(stated) {
                        at[axis] = place.unwrap_or(at[axis]);
                    }
                    at
                }),
            }),
        }
    }
}

/// Returns the series in whose middle a state is.
fn middle(state: &State) -> Option<Series> {
    if state.compensation.is_on() {
        return Some(Series::Compensation);
    }
    if state.nurbs.is_some() {
        return Some(Series::Nurbs);
    }
    let is_chain = state.cycle.active == Some(state.modal.motion);
    is_chain.then_some(Series::Cycle)
}

/// Returns the place of a state in machine coordinates, in millimetres and degrees.
pub fn place_mm(state: &State) -> Position {
    state.frame.machine_mm(state.position)
}

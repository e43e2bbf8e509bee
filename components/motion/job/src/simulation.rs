//! A program without its machine, line by line.
//!
//! Only the machine knows where a probe trips, and what an input or an item of HAL is. The simulation takes these answers
//! from the record of an earlier run. Without a record it refuses the program at that line.

use crate::{
    effects::Outputs,
    refusal::{Refusal, Unknown},
    world::World,
};
use hal_gcode::{
    Answer, Environment, Interpreter, Issued, Request, Step, Text,
    axis::Axis,
    error::Place,
    tool::{Tool, ToolTable},
};
use std::collections::VecDeque;

/// Rules of the machine for the answers that it need not give.
#[derive(Clone, Debug, Default)]
pub struct KnownAnswers {
    /// Place for tool changes in millimetres; axes without a coordinate stay where they are.
    pub change_position: Option<[Option<f64>; 9]>,
    /// Answers of an earlier run, in their order.
    pub answers: VecDeque<Answer>,
    /// Outputs that the program has set before its begin.
    pub outputs: Outputs,
    /// The tool table of an earlier run, if it is not that of the world.
    pub tools: Option<ToolTable>,
}

/// A program and the answers that are known.
pub struct Simulation {
    /// The interpreter, between two lines.
    pub interpreter: Interpreter,
    /// The calls of the last line.
    pub calls: Vec<Issued>,
    given: KnownAnswers,
}

/// Facts of the world, with the tool table of an earlier run.
struct Asked<'a> {
    world: &'a World,
    tools: Option<&'a ToolTable>,
}

impl Environment for Asked<'_> {
    fn open(&self, name: &str) -> Option<Text> {
        self.world.open(name)
    }
    fn refusal(&self, name: &str) -> Option<Box<str>> {
        self.world.refusal(name)
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
        self.world.hal(name)
    }
    fn function(&self, name: &str) -> bool {
        self.world.function(name)
    }
    fn user_code(&self, code: u16) -> Result<bool, Box<str>> {
        self.world.user_code(code)
    }
}

impl Simulation {
    /// Returns the simulation of a program that this interpreter has loaded.
    pub fn new(interpreter: Interpreter, given: KnownAnswers) -> Self {
        Self { interpreter, calls: Vec::new(), given }
    }

    /// Runs a line with its questions. Returns false at the end of the program.
    ///
    /// # Errors
    /// The line has an error, or asks for a fact that is not known.
    pub fn step(&mut self, world: &World) -> Result<bool, Refusal> {
        let tools = self.given.tools.take();
        let asked = Asked { world, tools: tools.as_ref() };
        let mut calls = core::mem::take(&mut self.calls);
        calls.clear();
        let mut step = self.interpreter.next(&asked, &mut calls);
        let result = loop {
            match step {
                Ok(Step::Ask(request)) => match self.answer(&request) {
                    Ok(answer) => {
                        step = self.interpreter.answer(&answer, &asked, &mut calls);
                    }
                    Err(refusal) => break Err(refusal),
                },
                Ok(step) => break Ok(step != Step::Ended),
                Err(error) => break Err(Refusal::Program(Box::new(error))),
            }
        };
        // Nothing takes the changes of a dry run back.
        drop(self.interpreter.state.numbered.take_changes());
        self.calls = calls;
        self.given.tools = tools;
        result
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
            Request::Hal { .. } => unknown(Unknown::Hal),
            Request::Function { .. } => unknown(Unknown::Function),
            Request::UserCode { .. } | Request::Finish => Ok(Answer::Done),
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

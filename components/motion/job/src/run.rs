//! A program from its begin to its end, with the answers of a machine that stands still.

use crate::world::World;
use core::cell::RefCell;
use hal_gcode::{Answer, Environment, Error, Interpreter, Issued, Request, Step};
use hal_remap::Functions;

/// Answers of the machine that is not there.
#[derive(Clone, Copy)]
pub struct Answers<'a> {
    /// Probes trip at the end of their move.
    pub probe_trips: bool,
    /// Functions in Python, if they run here.
    pub functions: Option<&'a RefCell<Functions>>,
}

impl Answers<'_> {
    /// Returns the answer to a question.
    pub fn answer(
        self,
        request: &Request,
        interpreter: &Interpreter,
        world: &dyn Environment,
    ) -> Answer {
        let state = &interpreter.state;
        match request {
            Request::Probe => {
                let here = state.frame.machine_mm(state.position);
                Answer::Probe { tripped_at: here, stopped_at: here, tripped: self.probe_trips }
            }
            Request::ToolChange { .. } => Answer::ToolChange { position: None },
            Request::Input { .. } => Answer::Input(0.0),
            // The environment has those that are known.
            Request::Hal { .. } => Answer::Hal(Vec::new()),
            Request::Function { .. } => {
                let functions = self.functions.and_then(|f| f.try_borrow_mut().ok());
                let step = match functions {
                    Some(mut functions) => functions.step(state, world),
                    None => Err("functions in Python do not run here".to_owned()),
                };
                step.map_or_else(|why| Answer::Failed(why.into()), Answer::Function)
            }
            Request::UserCode { .. } | Request::Finish => Answer::Done,
        }
    }
}

/// Runs one step; a question is answered in the same step.
pub fn step(
    interpreter: &mut Interpreter,
    world: &dyn Environment,
    answers: Answers<'_>,
    out: &mut Vec<Issued>,
) -> Result<bool, Error> {
    let mut step = interpreter.next(world, out)?;
    while let Step::Ask(request) = step {
        let answer = answers.answer(&request, interpreter, world);
        step = interpreter.answer(&answer, world, out)?;
    }
    Ok(step != Step::Ended)
}

/// Runs to the end of the program and hands each call out.
///
/// # Errors
/// The program has an error; or `each` returns one.
pub fn run(
    interpreter: &mut Interpreter,
    world: &World,
    answers: Answers<'_>,
    mut each: impl FnMut(&Interpreter, &Issued) -> Result<(), Stop>,
) -> Result<(), Stop> {
    let mut out = Vec::new();
    loop {
        let going = step(interpreter, world, answers, &mut out);
        for issued in out.drain(..) {
            each(interpreter, &issued)?;
        }
        if !going? {
            return Ok(());
        }
    }
}

/// The reason why a run stopped before its end.
#[derive(Debug)]
pub enum Stop {
    /// An error of the program.
    Program(Box<Error>),
    /// The output could not be written.
    Output(String),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Program(Box::new(error))
    }
}

/// Puts the tool of pocket 0 into the spindle of a random tool changer, and runs the code that the INI file asks for
/// before the first program.
///
/// # Errors
/// The code has an error.
pub fn start(interpreter: &mut Interpreter, world: &World) -> Result<(), String> {
    let machine = &world.machine;
    let in_spindle = machine.tools.tools.iter().find(|t| t.pocket == 0);
    if let Some(tool) = in_spindle.filter(|_| machine.settings.random_changer) {
        interpreter.state.tool = tool.clone();
    }
    let Some(code) = world.machine.startup.as_deref() else { return Ok(()) };
    interpreter.mdi(code);
    let answers = Answers { probe_trips: false, functions: None };
    let mut out = Vec::new();
    loop {
        match step(interpreter, world, answers, &mut out) {
            Ok(true) => out.clear(),
            Ok(false) => return Ok(()),
            Err(error) => {
                return Err(format!("[RS274NGC]RS274NGC_STARTUP_CODE: {}", error.problem));
            }
        }
    }
}

impl core::fmt::Display for Stop {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Program(error) => error.fmt(f),
            Self::Output(reason) => f.write_str(reason),
        }
    }
}

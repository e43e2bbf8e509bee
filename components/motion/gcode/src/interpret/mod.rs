//! The interpreter: reads a line, runs it, hands out its canonical calls.

pub mod block;
mod check;
pub mod codes;
mod effects;
mod execute;
mod feed;
mod function;
mod hal;
mod io;
mod offsets;
mod position;
mod read;
pub mod remap;
mod remark;
mod rs274d;
mod stop;
mod tools;

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    axis::Position,
    canon::{Call, Frame, Issued},
    environment::{Environment, Text},
    error::{Error, Place, Problem},
    function::Hook,
    parameters::{Names, Numbered},
    program::Sources,
    question::{Answer, Request},
    state::{
        Compensation, Cursor, Cycle, Level, LevelKind, Modal, Remapped, Rs274d, Settings, State,
    },
    text::{expression::Left, line::Line},
    tool::Tool,
};
pub use execute::Run;

/// The result of one step.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A line was run; there are more.
    Line,
    /// The interpreter waits for an answer.
    Ask(Request),
    /// The program ended.
    Ended,
}

/// The place of a problem on its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BlockErrorAt {
    /// The whole line.
    Line,
    /// The number of bytes from the place to the end of the cleaned line.
    Left(Left),
    /// This byte of the raw line.
    Raw(usize),
}

/// A problem and its place on the line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BlockError {
    pub(crate) at: BlockErrorAt,
    pub(crate) problem: Problem,
}

impl From<Problem> for BlockError {
    fn from(problem: Problem) -> Self {
        Self { at: BlockErrorAt::Line, problem }
    }
}

/// The interpreter. Its [`State`] is everything that a run depends on; the rest is a cache.
pub struct Interpreter {
    /// The state.
    pub state: State,
    pub(crate) sources: Sources,
    raw: Vec<u8>,
    cleaned: Vec<u8>,
    line: Line,
    block: block::Block,
    /// Calls of an O-word, which hands them out at its end.
    pub(crate) late: Vec<Issued>,
    /// Values of HAL for the next line.
    hal: hal::Known,
    /// The places of a problem in lines that a code reads ahead, the innermost last.
    pub(crate) problem_at: Vec<Place>,
    /// The block to go on with after an O-word that ended a remapped code.
    pub(crate) remapped: Option<Box<Remapped>>,
}

impl Interpreter {
    /// Returns an interpreter at power-on, with the parameters of the parameter file.
    pub fn new(settings: Settings, numbered: Numbered) -> Self {
        let modal = Modal::new(settings.program_unit, settings.spindles);
        let frame = Frame::new(settings.program_unit);
        let state = State {
            settings,
            modal,
            frame,
            position: Position::default(),
            numbered,
            globals: Names::new(),
            levels: Vec::new(),
            mdi: None,
            tool: Tool::default(),
            selected: None,
            changed_tools: BTreeMap::new(),
            returned: None,
            cycle: Cycle::default(),
            compensation: Compensation::default(),
            nurbs: None,
            spline: None,
            pending: None,
            line: 0,
            ended: true,
            lines_run: 0,
            lines_quiet: 0,
            probe_file: false,
            rs274d: Rs274d::default(),
            functions_called: 0,
        };
        let mut out = Self::from_state(state);
        out.load_system();
        out
    }

    /// Returns an interpreter that goes on where `state` was saved.
    pub fn from_state(state: State) -> Self {
        let mut sources = Sources::default();
        if let Some(text) = &state.mdi {
            sources.put("", Arc::new(text.as_bytes().to_vec()));
        }
        let (cleaned, line, block) = (Vec::new(), Line::default(), block::Block::default());
        Self {
            state,
            sources,
            raw: Vec::new(),
            cleaned,
            line,
            block,
            late: Vec::new(),
            hal: hal::Known::new(),
            problem_at: Vec::new(),
            remapped: None,
        }
    }

    /// Begins a program. Modal state, offsets and global parameters stay.
    pub fn load(&mut self, name: &str, text: Text) {
        self.sources = Sources::default();
        self.sources.put(name, text);
        let percent = self.begins_with_percent(name);
        self.state.mdi = None;
        self.state.rs274d = Rs274d::default();
        self.begin(Level::new(name.into(), Cursor::default(), LevelKind::Main { percent }));
    }

    /// Gives the text of a file, such as that of the main program to an interpreter made of a saved state.
    pub fn supply(&mut self, name: &str, text: Text) {
        self.sources.put(name, text);
    }

    /// Begins a line of MDI.
    pub fn mdi(&mut self, text: &str) {
        self.state.mdi = Some(text.into());
        self.sources.put("", Arc::new(text.as_bytes().to_vec()));
        self.begin(Level::new(Box::default(), Cursor::default(), LevelKind::Mdi));
    }

    fn begin(&mut self, level: Level) {
        let state = &mut self.state;
        state.levels = vec![level];
        state.pending = None;
        state.ended = false;
        state.line = 0;
        state.lines_run = 0;
        state.lines_quiet = 0;
    }

    /// Runs the next line and adds its canonical calls to `out`.
    pub fn next(&mut self, env: &dyn Environment, out: &mut Vec<Issued>) -> Result<Step, Error> {
        if self.state.ended {
            return Ok(Step::Ended);
        }
        if self.state.pending.is_some() {
            return Err(self.error(Problem::CalledBeforeAnswer.into(), &[]));
        }
        let before = out.len();
        let result = self.run_line(env, out);
        self.count(out.len() - before, result)
    }

    /// Takes the answer to the question of the last step and runs the rest of its line.
    pub fn answer(
        &mut self,
        answer: &Answer,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, Error> {
        let Some(pending) = self.state.pending.take() else {
            return Err(self.error(Problem::WrongAnswer.into(), &[]));
        };
        let before = out.len();
        let result = match pending.request {
            request @ Request::Hal { .. } => self.go_on_with_hal(request, answer, env, out),
            Request::Function { .. } => self.take_step(answer, env, out),
            _ => self.resume(pending, answer, env, out).map_err(|t| self.error(t, &[])),
        };
        self.count(out.len() - before, result)
    }

    /// Sets the position, in machine coordinates of millimetres and degrees, after motion that this interpreter did
    /// not order: a jog, an abort.
    pub fn synchronise(&mut self, machine_mm: Position) {
        let state = &mut self.state;
        let machine = machine_mm.scaled(1.0 / state.frame.unit.millimetres());
        state.position = state.frame.program(machine);
        state.compensation.forget();
        state.spline = None;
        state.nurbs = None;
    }

    /// Returns the calls that make the frame in force, to follow the calls from here on.
    pub fn preamble(&self) -> Vec<Call> {
        let frame = &self.state.frame;
        vec![
            Call::UseLengthUnits(frame.unit),
            Call::SetG5xOffset { system: self.state.modal.system, offset: frame.g5x },
            Call::SetG92Offset(frame.g92),
            Call::SetXyRotation(frame.rotation),
            Call::UseToolLengthOffset(frame.tool),
        ]
    }

    /// Returns the places of the line in execution: the innermost call last.
    pub fn places(&self) -> Vec<Place> {
        self.state.levels.iter().filter(|l| l.is_of_file()).map(Level::place).collect()
    }

    /// Reads a line of a file that is known or that the environment opens; `None` at its end.
    pub(crate) fn read(
        &mut self,
        file: &str,
        cursor: Cursor,
        env: &dyn Environment,
        line: &mut Vec<u8>,
    ) -> Result<Option<Cursor>, BlockError> {
        let longest = self.state.settings.limits.line_length;
        Ok(self.sources.line(file, cursor, longest, env, line)?)
    }

    fn count(&mut self, calls: usize, result: Result<Step, Error>) -> Result<Step, Error> {
        let limit = self.state.settings.limits.quiet_lines;
        if calls > 0 {
            self.state.lines_quiet = 0;
        } else if self.state.lines_quiet > limit {
            return Err(self.error(Problem::RunAway { limit }.into(), &[]));
        }
        let result = result.or_else(|error| self.tell_function(error));
        if result.is_err() {
            self.state.ended = true;
        }
        result
    }

    /// Keeps a line of the innermost level as the place of the problem that ends the line in execution.
    pub(crate) fn note_place(&mut self, line: u32) {
        self.problem_at = self.places();
        if let Some(place) = self.problem_at.last_mut() {
            place.line = line;
        }
    }

    pub(crate) fn error(&self, error: BlockError, raw: &[u8]) -> Error {
        if let Some((place, calls)) = self.problem_at.split_last() {
            let (place, calls) = (place.clone(), calls.to_vec());
            return Error { place, problem: error.problem, calls };
        }
        let mut places = self.places();
        // A prolog fails before its subroutine begins.
        if self.state.function().is_some_and(|f| f.hook == Hook::Prolog) {
            places.pop();
        }
        let mut place = places.pop().unwrap_or_default();
        place.line = self.state.line;
        place.column = match error.at {
            BlockErrorAt::Line => 0,
            BlockErrorAt::Raw(byte) => u32::try_from(byte).unwrap_or(u32::MAX).saturating_add(1),
            BlockErrorAt::Left(left) => {
                let left = usize::try_from(left).unwrap_or(0);
                let offset = self.cleaned.len().saturating_sub(left);
                crate::text::clean::column(raw, offset)
            }
        };
        Error { place, problem: error.problem, calls: places }
    }
}

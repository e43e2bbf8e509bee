//! The dry run: a program as far as one of its lines, without its machine.
//!
//! A start in the middle of a program needs the state that the lines before it make. The dry run computes it with
//! the interpreter that also runs the program. A fact that only the machine knows, and no record of an earlier run has, ends the
//! dry run with a refusal.

use crate::{
    effects::Effects,
    refusal::{LineBegin, Refusal, Series},
    simulation::{KnownAnswers, Simulation},
    world::World,
};
use hal_gcode::{Interpreter, State, axis::Position, error::Place};

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

/// A dry run on its way.
pub struct DryRun {
    program: Simulation,
    target: Target,
    main: Box<str>,
    seen: u32,
    /// The line whose times are counted, for a target that is a number.
    counted: Option<(Box<str>, u32)>,
    /// The last line from which a start is possible.
    good: Option<LineBegin>,
    effects: Effects,
    found: Option<Box<Found>>,
    refused: Option<Refusal>,
    /// The state before the place of a refusal in the middle of a series.
    refused_state: Option<Box<State>>,
    /// Lines that are still searched behind the place.
    rest: u64,
}

impl DryRun {
    /// Returns the dry run of a program that this interpreter has loaded.
    pub fn new(interpreter: Interpreter, target: Target, given: KnownAnswers) -> Self {
        let effects = Effects { outputs: given.outputs.clone(), ..Effects::default() };
        let main = interpreter.state.levels.first().map(|l| l.file.clone()).unwrap_or_default();
        Self {
            program: Simulation::new(interpreter, given),
            target,
            main,
            seen: 0,
            counted: None,
            good: None,
            effects,
            found: None,
            refused: None,
            refused_state: None,
            rest: 0,
        }
    }

    /// Counts the times of this line of a file, for a target that is a number.
    #[must_use]
    pub fn counting(self, file: &str, line: u32) -> Self {
        Self { counted: Some((file.into(), line)), ..self }
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
        self.program.interpreter.state = found.state.clone();
        self.program.interpreter
    }

    /// Takes the state before the place of a refusal in the middle of a series.
    pub const fn take_refused_state(&mut self) -> Option<Box<State>> {
        self.refused_state.take()
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
        let state = &self.program.interpreter.state;
        let level = state.levels.last();
        LineBegin {
            number: state.lines_run,
            file: level.map(|l| l.file.clone()).unwrap_or_default(),
            // A function has no line of its own.
            line: level.filter(|l| l.is_of_file()).map_or(0, |l| l.cursor.line + 1),
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
                is_line(here, file.as_deref().unwrap_or(&self.main), *line)
            }
            Target::Number(number) => here.number == *number,
        }
    }

    /// Tells whether a line is that whose times are counted.
    fn is_counted(&self, here: &LineBegin) -> bool {
        match &self.counted {
            Some((file, line)) => is_line(here, file, *line),
            None => self.is_wanted(here),
        }
    }

    /// Notes a line from which a start is possible, and the place itself.
    fn look(&mut self, here: &LineBegin) {
        let state = &self.program.interpreter.state;
        let middle = middle(state);
        if middle.is_none() {
            self.good = Some(here.clone());
        }
        self.seen += u32::from(self.is_counted(here));
        if !self.is_wanted(here) {
            return;
        }
        if let Target::Line { pass, .. } = self.target
            && self.seen != pass
        {
            return;
        }
        if let Some(of) = middle {
            let place = self.place(here);
            self.refused_state = Some(Box::new(state.clone()));
            self.refused = Some(Refusal::Middle { place, of, from: self.good.clone(), next: None });
            self.rest = NEXT_LINES;
            return;
        }
        let mut calls = self.program.interpreter.places();
        calls.pop();
        self.found = Some(Box::new(Found {
            state: state.clone(),
            begin: here.clone(),
            calls,
            pass: (self.seen.max(1), self.seen.max(1)),
            more: false,
            effects: self.effects.clone(),
        }));
        // A number without a line names one time.
        self.rest = if self.counts() { COUNTED_LINES } else { 0 };
    }

    /// Counts further times of a found place, or searches the next possible line. Returns whether this has ended.
    fn look_behind(&mut self, here: &LineBegin) -> bool {
        if let Some(Refusal::Middle { next, .. }) = &mut self.refused
            && middle(&self.program.interpreter.state).is_none()
        {
            *next = Some(here.clone());
            return true;
        }
        let is_place = self.found.as_ref().is_some_and(|f| f.begin.number == here.number);
        self.seen += u32::from(!is_place && self.found.is_some() && self.is_counted(here));
        if self.rest == 0 {
            let counts = self.counts();
            if let Some(found) = &mut self.found {
                found.more = counts;
            }
            return true;
        }
        self.rest -= 1;
        false
    }

    /// Tells whether the times of a line are counted.
    const fn counts(&self) -> bool {
        matches!(self.target, Target::Line { .. }) || self.counted.is_some()
    }

    fn place(&self, here: &LineBegin) -> Place {
        Place { file: here.file.clone(), line: here.line, column: 0 }
    }

    /// Runs a line. Returns false at the end of the program.
    fn step(&mut self, world: &World) -> Result<bool, Refusal> {
        let goes_on = self.program.step(world)?;
        self.program.calls.iter().for_each(|issued| self.effects.note(issued));
        Ok(goes_on)
    }
}

/// Tells whether this is the line of a file, whose name may lack its ending.
fn is_line(here: &LineBegin, file: &str, line: u32) -> bool {
    here.line == line && (*here.file == *file || *here.file == *file.trim_end_matches(".ngc"))
}

/// Returns the series in whose middle a state is.
fn middle(state: &State) -> Option<Series> {
    if state.compensation.is_on() {
        return Some(Series::Compensation);
    }
    if state.levels.iter().any(|l| l.function().is_some()) {
        return Some(Series::Function);
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

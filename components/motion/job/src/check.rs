//! The check of a whole program, before it runs or ahead of it.
//!
//! It finds what a look-ahead can know: errors of lines, tools that are not in the table, axes that the machine does not have,
//! and places beyond the limits. It ends at the first line that asks for a fact that only the machine knows.

use crate::{
    estimate::{Estimate, TimeTable},
    refusal::Refusal,
    simulation::{KnownAnswers, Simulation},
    threads::{Finding, Threads},
    way::Way,
    world::World,
};
use hal_gcode::{Call, Error, Interpreter, axis::Axis, error::Problem};
use std::collections::BTreeSet;

/// Largest number of reasons.
const MAX_REASONS: usize = 10;

/// A reason for which a program cannot run to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// Number of lines that run before the line.
    pub number: u64,
    /// The place and what is wrong there.
    pub text: String,
}

/// The part of a program that a check has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// There are more lines.
    Part,
    /// Everything.
    All,
    /// Everything before a line that asks for a fact that only the machine knows.
    Known,
}

/// A check on its way.
pub struct Check {
    program: Simulation,
    way: Way,
    estimate: Estimate,
    threads: Threads,
    times: TimeTable,
    /// Axes whose lower or upper limit has a reason already.
    beyond: BTreeSet<(Axis, bool)>,
    reasons: Vec<Reason>,
    seen: Seen,
    first: u64,
}

impl Check {
    /// Returns the check of a program that this interpreter has loaded.
    pub fn new(interpreter: Interpreter, given: KnownAnswers) -> Self {
        let state = &interpreter.state;
        let first = state.lines_run;
        Self {
            way: Way::new(state.frame, state.position),
            estimate: Estimate::new(state),
            threads: Threads::new(state),
            program: Simulation::new(interpreter, given),
            times: TimeTable::default(),
            beyond: BTreeSet::new(),
            reasons: Vec::new(),
            seen: Seen::Part,
            first,
        }
    }

    /// Returns the reasons so far, in the order of the program.
    pub fn reasons(&self) -> &[Reason] {
        &self.reasons
    }

    /// Returns how much of the program has been seen.
    pub fn seen(&self) -> Seen {
        self.seen
    }

    /// Returns the number of lines that had run before the check.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// Returns the number of lines that have run.
    pub fn number(&self) -> u64 {
        self.program.interpreter.state.lines_run
    }

    /// Returns the estimate of the seconds before a line, and of those of the whole program once all of it has been seen.
    pub fn seconds(&self, number: u64) -> (f64, Option<f64>) {
        let whole = (self.seen == Seen::All).then_some(self.estimate.seconds);
        (self.times.at(number), whole)
    }

    /// Runs at most `lines` lines.
    pub fn advance(&mut self, world: &World, lines: u32) {
        for _ in 0..lines {
            if self.seen != Seen::Part {
                return;
            }
            let number = self.number();
            self.times.add(number, self.estimate.seconds);
            let result = self.program.step(world);
            self.follow(number, world);
            match result {
                Ok(true) => {}
                Ok(false) => self.seen = Seen::All,
                Err(Refusal::Program(error)) => self.error(number, &error),
                Err(_) => self.seen = Seen::Known,
            }
        }
    }

    /// Follows the moves of a line.
    fn follow(&mut self, number: u64, world: &World) {
        let machine = &world.machine;
        let state = &self.program.interpreter.state;
        let unit = state.frame.unit.millimetres();
        let has_limits = machine.kinematics.is_none();
        for issued in &self.program.calls {
            self.estimate.call(issued);
            if matches!(issued.call, Call::ReloadToolData) {
                // Somebody may have edited the table.
                self.seen = Seen::Known;
            }
            let start = self.way.at;
            let mut from = start;
            let mut points = Vec::new();
            let (estimate, beyond, reasons) =
                (&mut self.estimate, &mut self.beyond, &mut self.reasons);
            self.way.follow(&issued.call, &mut |kind, to| {
                points.push((kind, to));
                estimate.add(machine, kind, unit, from, to);
                from = to;
                for (axis, is_upper, limit) in machine.beyond(to).filter(|_| has_limits) {
                    if !beyond.insert((axis, is_upper)) || reasons.len() >= MAX_REASONS {
                        continue;
                    }
                    let file = state.levels.last().map(|l| &*l.file).unwrap_or_default();
                    reasons.push(Reason {
                        number,
                        text: format!(
                            "{file}:{}: {}",
                            issued.line,
                            machine.excess((axis, is_upper, limit), to[axis])
                        ),
                    });
                }
            });
            let found = self.threads.call(machine, issued, state, start, &points);
            if let Some(Finding { line, text }) = found.filter(|_| reasons.len() < MAX_REASONS) {
                let file = state.levels.last().map(|l| &*l.file).unwrap_or_default();
                reasons.push(Reason { number, text: format!("{file}:{line}: {text}") });
            }
            if matches!(issued.call, Call::ChangeTool(_)) {
                self.way.at = state.frame.machine_mm(state.position);
            }
        }
    }

    /// Notes the error of a line and goes on behind it.
    fn error(&mut self, number: u64, error: &Error) {
        let is_last = matches!(
            error.problem,
            Problem::NoProgramEnd
                | Problem::LinesSpent { .. }
                | Problem::RunAway { .. }
                | Problem::NoFile { .. }
        );
        // A tool that is missing cannot be changed either.
        let follows = matches!(error.problem, Problem::NoToolSelected) && !self.reasons.is_empty();
        if !follows {
            self.reasons.push(Reason { number, text: error.to_string() });
        }
        let state = &mut self.program.interpreter.state;
        if is_last || self.reasons.len() >= MAX_REASONS || state.levels.is_empty() {
            self.seen = Seen::All;
            return;
        }
        (state.ended, state.pending, state.nurbs) = (false, None, None);
    }
}

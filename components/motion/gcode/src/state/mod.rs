//! The whole state of the interpreter as a value: cloned, compared, saved and loaded.

pub mod codes;
pub mod compensation;
pub mod curve;
pub mod level;
pub mod modal;
pub mod rs274d;
pub mod settings;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    axis::Position,
    canon::Frame,
    dialect::Dialect,
    error::Problem,
    function::{Function, Hook},
    interpret::block::Block,
    parameters::{Names, Numbered, set_name},
    question::Request,
    tool::Tool,
};
pub use compensation::Compensation;
pub use curve::{Cycle, Nurbs};
pub use level::{Cursor, Level, LevelKind, Open, OpenKind, Remapped, Saved};
pub use modal::{FeedMode, Modal, Side};
pub use rs274d::Rs274d;
pub use settings::{Limits, Settings};

/// The local parameter that has the number of arguments of a call.
const ARGUMENT_COUNT: &str = "n_args";

/// A block that waits for an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pending {
    /// The question.
    pub request: Request,
    /// The block.
    pub block: Block,
    /// The step of its execution that asked.
    pub step: u8,
}

/// The whole state of the interpreter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// The settings.
    pub settings: Settings,
    /// The modal state.
    pub modal: Modal,
    /// Unit and offsets.
    pub frame: Frame,
    /// The current position in program coordinates and units; without compensation.
    pub position: Position,
    /// The numbered parameters.
    pub numbered: Numbered,
    /// The global named parameters.
    pub globals: Names,
    /// The file, place and locals of the main program and of each call, the innermost last.
    pub levels: Vec<Level>,
    /// The text of a line of MDI.
    pub mdi: Option<Box<str>>,
    /// The tool in the spindle.
    pub tool: Tool,
    /// The selected tool, if one was.
    pub selected: Option<i32>,
    /// Tools that G10 changed since the table was read.
    pub changed_tools: BTreeMap<i32, Tool>,
    /// The result of the last subroutine.
    pub returned: Option<f64>,
    /// The sticky words of canned cycles.
    pub cycle: Cycle,
    /// The compensation and its queue of moves.
    pub compensation: Compensation,
    /// The control points of a NURBS that is not finished.
    pub nurbs: Option<Nurbs>,
    /// The second control point of the last G5.
    pub spline: Option<(f64, f64)>,
    /// The block that waits for an answer.
    pub pending: Option<Pending>,
    /// The line in execution, from 1.
    pub line: u32,
    /// The end of the program was reached.
    pub ended: bool,
    /// The lines that were run.
    pub lines_run: u64,
    /// The lines since the last canonical call.
    pub lines_quiet: u64,
    /// A probe moves with compensation, so the file of the probe's results is open.
    pub probe_file: bool,
    /// The values of a program in RS274-D beyond the modal ones.
    pub rs274d: Rs274d,
    /// The functions of another language that were called.
    pub functions_called: u64,
}

impl State {
    /// Tells whether the next line is in RS274-D: a line of a program, not of MDI.
    pub(crate) fn is_rs274d(&self) -> bool {
        self.settings.dialect == Dialect::Rs274d
            && matches!(self.levels.last(), Some(Level { kind: LevelKind::Main { .. }, .. }))
    }

    /// Returns the function of another language that is the innermost level.
    pub fn function(&self) -> Option<&Function> {
        self.levels.last().and_then(Level::function)
    }

    /// Returns the level whose local parameters are in force: the subroutine of a prolog or epilog, and the level of
    /// the function for a line that it executes.
    pub fn scope(&self) -> Option<&Level> {
        self.levels.get(self.scope_index())
    }

    /// Returns the level whose local parameters are in force.
    pub fn scope_mut(&mut self) -> Option<&mut Level> {
        let index = self.scope_index();
        self.levels.get_mut(index)
    }

    /// Gives a call the number of its arguments, if the INI file asks for it.
    pub(crate) fn count_arguments(&self, level: &mut Level, count: usize) -> Result<(), Problem> {
        if !self.settings.counts_arguments {
            return Ok(());
        }
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        set_name(&mut level.locals, ARGUMENT_COUNT, f64::from(count))
    }

    /// Tells whether a name is that of the number of arguments, which a call cannot change.
    pub(crate) fn is_argument_count(&self, name: &str) -> bool {
        let is_call = |l: &Level| matches!(l.kind, LevelKind::Sub | LevelKind::Part(..));
        self.settings.counts_arguments
            && name == ARGUMENT_COUNT
            && self.scope().is_some_and(is_call)
    }

    fn scope_index(&self) -> usize {
        let passes = |level: &Level| match &level.kind {
            LevelKind::Text(_) => true,
            LevelKind::Function(f) => matches!(f.hook, Hook::Prolog | Hook::Epilog),
            _ => false,
        };
        let index = self.levels.iter().rposition(|level| !passes(level));
        index.unwrap_or_default()
    }

    /// Returns the number of calls in progress, without the lines and functions around them.
    pub fn call_level(&self) -> usize {
        let counts = |l: &&Level| match l.function() {
            Some(function) => matches!(function.hook, Hook::Body | Hook::Word),
            None => l.is_of_file(),
        };
        self.levels.iter().filter(counts).count().saturating_sub(1)
    }
}

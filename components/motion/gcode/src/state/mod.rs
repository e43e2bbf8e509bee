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
    interpret::block::Block,
    parameters::{Names, Numbered},
    question::Request,
    tool::Tool,
};
pub use compensation::Compensation;
pub use curve::{Cycle, Nurbs};
pub use level::{Cursor, Level, LevelKind, Open, OpenKind, Remapped, Saved};
pub use modal::{FeedMode, Modal, Side};
pub use rs274d::Rs274d;
pub use settings::{Limits, Settings};

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
}

impl State {
    /// Tells whether the next line is in RS274-D: a line of a program, not of MDI.
    pub(crate) fn is_rs274d(&self) -> bool {
        self.settings.dialect == Dialect::Rs274d
            && matches!(self.levels.last(), Some(Level { kind: LevelKind::Main { .. }, .. }))
    }
}

//! Levels of a program: the main program and the calls in progress, with their places and open loops.

use serde::{Deserialize, Serialize};

use super::{Compensation, Modal};
use crate::{
    axis::Position, error::Place, function::Function, interpret::block::Block, parameters::Names,
};

/// A place between two lines of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cursor {
    /// The bytes before it.
    pub offset: u64,
    /// The lines before it.
    pub line: u32,
}

/// A loop or condition in progress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Open {
    /// The label.
    pub label: Box<str>,
    /// The kind.
    pub kind: OpenKind,
}

/// The kind of a loop or condition, with the place to continue at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum OpenKind {
    /// `while` at this place.
    While(Cursor),
    /// `do`, whose first line is at this place.
    Do(Cursor),
    /// `repeat`, whose first line is at this place, with the passes left.
    Repeat(Cursor, u32),
    /// `if`
    If,
}

/// The kind of a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LevelKind {
    /// The main program; `percent` tells that a percent sign ends it.
    Main {
        /// A percent sign ends it.
        percent: bool,
    },
    /// A line of MDI.
    Mdi,
    /// A subroutine.
    Sub,
    /// A part that M98 called, with its begin and the passes left.
    Part(Cursor, u32),
    /// A function of another language.
    Function(Box<Function>),
    /// A line that a function executes, until it was read.
    Text(Option<Box<str>>),
}

/// A level of the program: the main program or a call.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// The file.
    pub file: Box<str>,
    /// The next line.
    pub cursor: Cursor,
    /// The kind.
    pub kind: LevelKind,
    /// The label of the subroutine.
    pub label: Box<str>,
    /// Local named parameters.
    pub locals: Names,
    /// Parameters 1 to 30 of the caller.
    pub saved: Vec<f64>,
    /// Loops and conditions in progress.
    pub open: Vec<Open>,
    /// The modal state that M70 or M73 saved.
    pub modal: Option<Box<Saved>>,
    /// The modal state returns at the end of the level (M73).
    pub restores: bool,
    /// The pass of the innermost loop, counted over the level.
    pub pass: u64,
    /// The block whose remapped code runs in this level.
    pub remapped: Option<Box<Remapped>>,
}

impl Level {
    /// Returns a level that begins at `cursor`.
    pub fn new(file: Box<str>, cursor: Cursor, kind: LevelKind) -> Self {
        Self {
            file,
            cursor,
            kind,
            label: Box::default(),
            locals: Names::new(),
            saved: Vec::new(),
            open: Vec::new(),
            modal: None,
            restores: false,
            pass: 0,
            remapped: None,
        }
    }

    /// Returns the function that this level is.
    pub fn function(&self) -> Option<&Function> {
        match &self.kind {
            LevelKind::Function(function) => Some(function),
            _ => None,
        }
    }

    /// Tells whether the level has lines of a file.
    pub fn is_of_file(&self) -> bool {
        !matches!(self.kind, LevelKind::Function(_) | LevelKind::Text(_))
    }

    /// Returns the place of the line that was read last.
    pub fn place(&self) -> Place {
        Place { file: self.file.clone(), line: self.cursor.line, column: 0 }
    }
}

/// The modal state that M70 and M73 save.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    /// The modal state.
    pub modal: Modal,
    /// The tool length offset.
    #[serde(default)]
    pub offset: Position,
    /// The side and the tool of cutter radius compensation.
    #[serde(default)]
    pub compensation: Compensation,
}

/// A block whose remapped code is in execution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remapped {
    /// The remap, with its place in the settings.
    pub index: usize,
    /// The block.
    pub block: Block,
    /// The step of its execution that the code replaces.
    pub step: u8,
    /// The code was used inside of its own subroutine, where it means what it did before.
    pub builtin_used: bool,
}

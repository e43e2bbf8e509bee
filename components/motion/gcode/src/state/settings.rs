//! Settings of the machine and limits of the interpreter.

use serde::{Deserialize, Serialize};

use crate::{axis::AxisMask, canon::Unit, dialect::Dialect, remap::Remap};

/// Bounds on what a program may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// The most nested calls.
    pub levels: u32,
    /// The most nested loops and conditions of one level.
    pub open: u32,
    /// The most lines in a row that make no canonical call.
    pub quiet_lines: u64,
    /// The most lines of a run.
    pub lines: u64,
    /// The longest line in bytes.
    pub line_length: usize,
    /// The most canonical calls of one line.
    pub calls: usize,
    /// The most steps of one function of another language.
    pub turns: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            levels: 10,
            open: 100,
            quiet_lines: 10_000_000,
            lines: u64::MAX,
            line_length: 4096,
            calls: 1_000_000,
            turns: 1_000_000,
        }
    }
}

/// Facts of the machine that the INI file states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The axes of the machine.
    pub axes: AxisMask,
    /// Rotary axes whose absolute positions mean a direction within one turn.
    pub wrapped: AxisMask,
    /// The unit of the parameter file and tool table.
    pub unit: Unit,
    /// The unit before the first G20 or G21.
    pub program_unit: Unit,
    /// The number of spindles.
    pub spindles: u8,
    /// Lines that begin with `/` are not run.
    pub block_delete: bool,
    /// The largest difference of an arc's radii that is always allowed, in millimetres.
    pub arc_tolerance: f64,
    /// The bounds on programs.
    pub limits: Limits,
    /// The machine moves: `#<_task>` is 1. In a preview or check it is 0.
    pub task: bool,
    /// The tool changer puts the old tool into the pocket of the new one.
    pub random_changer: bool,
    /// M98 and O-words without a keyword are refused (`[RS274NGC]DISABLE_FANUC_STYLE_SUB`).
    #[serde(default)]
    pub no_fanuc_subs: bool,
    /// `#<n_args>` is the number of arguments of a call (`[RS274NGC]OWORD_NARGS`).
    #[serde(default)]
    pub counts_arguments: bool,
    /// The angle in degrees that M19 adds to its R (`[RS274NGC]ORIENT_OFFSET`).
    #[serde(default)]
    pub orient_offset: f64,
    /// The remapped codes.
    pub remaps: Vec<Remap>,
    /// The language of programs.
    pub dialect: Dialect,
    /// The feed of a program in RS274-D that has no F, in millimetres per minute.
    pub default_feed: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            axes: AxisMask::ALL,
            wrapped: AxisMask(0),
            unit: Unit::Millimetre,
            program_unit: Unit::Millimetre,
            spindles: 1,
            block_delete: true,
            arc_tolerance: 0.0127,
            limits: Limits::default(),
            task: false,
            random_changer: false,
            no_fanuc_subs: false,
            counts_arguments: false,
            orient_offset: 0.0,
            remaps: Vec::new(),
            dialect: Dialect::default(),
            default_feed: 381.0,
        }
    }
}

//! Records of the service `operator`: buttons and lamps of an operator for the task.

use crate::{Record, Status};
use core::ffi::c_void;

/// Length of the text of an [`OperatorCommand`] in bytes.
pub const OPERATOR_TEXT: usize = 240;

/// A request of the operator to the task.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct OperatorCommand {
    /// `size_of::<OperatorCommand>()` at compile time.
    pub size: u32,
    /// Kind: 1 mode, 2 run, 3 pause, 4 resume, 5 step, 6 stop, 7 optional stop, 8 block delete, 9
    /// MDI.
    pub kind: u32,
    /// Mode (0 manual, 1 auto, 2 MDI), or 1 for on and 0 for off.
    pub value: u32,
    /// Number of bytes of `text`.
    pub len: u32,
    /// Line of MDI, in UTF-8.
    pub text: [u8; OPERATOR_TEXT],
    /// Stop epoch in which the request was made; 0 is none.
    pub epoch: u64,
}

impl OperatorCommand {
    /// The empty record.
    pub const EMPTY: Self = Self {
        size: crate::size::<Self>(),
        kind: 0,
        value: 0,
        len: 0,
        text: [0; OPERATOR_TEXT],
        epoch: 0,
    };
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for OperatorCommand {
    const MIN: usize = core::mem::offset_of!(Self, epoch);
}

/// State of the task for the operator. Lengths are in machine units.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorView {
    /// `size_of::<OperatorView>()` at compile time.
    pub size: u32,
    /// Mode: 0 manual, 1 auto, 2 MDI.
    pub mode: u32,
    /// Program: 0 idle, 1 running, 2 paused.
    pub program: u32,
    /// 1 while M1 pauses.
    pub optional_stop: u32,
    /// 1 while lines that begin with / are left out.
    pub block_delete: u32,
    /// Zero; reserved for later versions.
    pub reserved: u32,
    /// Diameter of the tool in the spindle.
    pub tool_diameter: f64,
    /// Sum of all offsets of the program: the pose at which its coordinates are zero.
    pub zero: [f64; 9],
    /// Rotation of the program's coordinates about Z in degrees.
    pub rotation: f64,
}

impl OperatorView {
    /// State of a task that does nothing.
    pub const IDLE: Self = Self {
        size: crate::size::<Self>(),
        mode: 0,
        program: 0,
        optional_stop: 0,
        block_delete: 0,
        reserved: 0,
        tool_diameter: 0.0,
        zero: [0.0; 9],
        rotation: 0.0,
    };
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for OperatorView {
    const MIN: usize = size_of::<Self>();
}

/// Function table of the service `operator`, version 1. The task uses it, from its worker.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Operator {
    /// `size_of::<Operator>()` at compile time.
    pub size: u32,
    /// Zero; reserved for later versions.
    pub flags: u32,
    /// Context that is passed to the functions.
    pub ctx: *const c_void,
    /// Takes the oldest request. Returns [`Status::EAGAIN`] if there is none. The caller sets the
    /// size of the record.
    pub take: Option<unsafe extern "C" fn(*const c_void, *mut OperatorCommand) -> Status>,
    /// Shows the state of the task.
    pub show: Option<unsafe extern "C" fn(*const c_void, *const OperatorView) -> Status>,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Operator {
    const MIN: usize = size_of::<Self>();
}

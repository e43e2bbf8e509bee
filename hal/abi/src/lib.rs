//! Binary interface (ABI) between the Ferrule engine and a plugin library.
//!
//! A plugin exports a [`Library`] named `hal_library_<file stem>`. It also exports the names in it
//! as [`names`], `hal_names_<file stem>`. The engine reads these names from the file to find the
//! library that offers a component. It opens that library, reads the [`Library`], calls
//! [`ComponentType::create`] with a [`Host`], and then runs the functions that the component
//! registered. These rules hold for everything here:
//!
//! - every record is `#[repr(C)]` and begins with its own size; a field beyond that size reads as
//!   zero, so a minor version may append fields. Major versions must be equal;
//! - lists are arrays of pointers to records, so that records may grow;
//! - a function pointer never unwinds; a panic is returned as [`Status::EFAULT`];
//! - a value is one 64-bit [`Cell`] and is never accessed at another width.
#![no_std]
#![expect(unsafe_code, reason = "one of the crates that keep the binary contract")]

mod argument;
mod cell;
mod foreign;
mod homing;
mod host;
mod motion;
pub mod names;
mod operator;
mod page;
mod plain;
mod port;
mod record;
mod ring;
pub mod seqlock;
mod service;
mod spec;
mod sync;
mod ticket;
mod worker;

pub use argument::{ArgSpec, FROM_AFAR, arg, arg_bounds};
pub use cell::{Cell, Slot};
pub use foreign::{ForeignFile, ForeignLoader, Load, edit};
pub use homing::{Homing, HomingJoint, HomingSettings, homing_call, homing_flags, homing_state};
pub use host::{ArgValue, CallHost, HARDWARE_FAILURE, Host, ServiceRef, StreamRef, host_flags};
pub use motion::{
    MOTION_TEXT, Motion, MotionAnswer, MotionCommand, motion_flags, motion_kind, motion_setting,
    motion_source,
};
pub use operator::{OPERATOR_TEXT, Operator, OperatorCommand, OperatorView};
pub use page::{MAX_PAGE_WORDS, PAGE_MAGIC, Page, PageReader, PageWriter};
pub use plain::{FieldSpec, SnapshotRef, SnapshotSpec};
pub use port::PortQueue;
pub use record::{List, Record, Status, Str};
pub use ring::{Consumer, Got, MAX_WIDTH, Producer, RING_MAGIC, Ring};
pub use service::{Interlock, IoCommand, IoControl, IoOutcome, IoStatus, Kinematics, ServiceSpec};
pub use spec::{
    ActionSpec, CommandRun, CommandSpec, ComponentType, Create, Free, FunctSpec, ItemSpec, Library,
    Run, StreamSpec, TaskSpec, ThreadSpec, Use, access, component_flags, funct_flags, item_flags,
    panic_strategy, stream_direction, thread_flags,
};
pub use ticket::{TICKET_NUMBERS, Ticket, TicketState};
pub use worker::{Work, WorkerSpec};

/// Major version, which changes when an existing field or rule changes. Engine and library must
/// have the same one.
pub const ABI_MAJOR: u32 = 1;
/// Minor version, which increases when something is appended. The engine must be at least as new as
/// the library.
pub const ABI_MINOR: u32 = 12;
/// Maximum length of the name of a pin, parameter, signal, function, thread or component, in bytes.
pub const NAME_LEN: usize = 55;

/// Returns the size of a record, as its first field states it.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "no record is near 4 GiB")]
pub const fn size<T>() -> u32 {
    size_of::<T>() as u32
}

/// HAL type codes (the values LinuxCNC uses).
pub mod ty {
    /// A boolean; true if the low byte is not zero.
    pub const BIT: u8 = 1;
    /// A 64-bit floating-point number.
    pub const FLOAT: u8 = 2;
    /// A signed 32-bit integer in the low half of the cell.
    pub const S32: u8 = 3;
    /// An unsigned 32-bit integer in the low half of the cell.
    pub const U32: u8 = 4;
    /// A byte queue; the cell holds the address of a [`PortQueue`](crate::PortQueue), or zero.
    pub const PORT: u8 = 5;
    /// A signed 64-bit integer.
    pub const S64: u8 = 6;
    /// An unsigned 64-bit integer.
    pub const U64: u8 = 7;
}

/// Directions of pins and parameters (the values LinuxCNC uses).
pub mod dir {
    /// A pin that the component reads.
    pub const IN: u8 = 16;
    /// A pin that the component writes.
    pub const OUT: u8 = 32;
    /// A pin that its component and others write.
    pub const IO: u8 = 48;
    /// A parameter that the component reports.
    pub const RO: u8 = 64;
    /// A parameter that the user sets.
    pub const RW: u8 = 192;
}

/// Message levels (the values LinuxCNC uses).
pub mod level {
    /// Text for the operator, logged at every message level.
    pub const NOTICE: u8 = 0;
    /// An error.
    pub const ERR: u8 = 1;
    /// A warning.
    pub const WARN: u8 = 2;
    /// Information.
    pub const INFO: u8 = 3;
    /// Debugging detail.
    pub const DBG: u8 = 4;
}

//! Function tables that one plugin offers to others.

use crate::{Free, Record, Status, Str, Use};
use core::{ffi::c_void, mem::offset_of};

/// A function table for other plugins. The state is owned as in [`FunctSpec`](crate::FunctSpec).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ServiceSpec {
    /// `size_of::<ServiceSpec>()` at compile time.
    pub size: u32,
    /// Version of the table. Provider and user must have the same version.
    pub version: u32,
    /// Name of the service, such as `kinematics`. Each name has at most one provider.
    pub name: Str,
    /// The table, `#[repr(C)]`. Name and version determine its layout.
    pub table: *const c_void,
    /// State of the service.
    pub state: *mut c_void,
    /// Function that frees the state.
    pub free: Option<Free>,
    /// Pins, parameters and hidden state that its functions access. Functions that call the service
    /// inherit these edges.
    pub uses: *const Use,
    /// Number of entries in `uses`.
    pub n_uses: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ServiceSpec {
    const MIN: usize = size_of::<Self>();
}

/// Function table of the service `kinematics`, version 1. A pose is x y z a b c u v w.
///
/// Its functions return [`Status::OK`], [`Kinematics::SINGULAR`] (also a valid solution), or the
/// reason why there is no solution. Without a solution they leave their output unchanged.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Kinematics {
    /// `size_of::<Kinematics>()` at compile time.
    pub size: u32,
    /// Number of joints.
    pub joints: u32,
    /// Kind: [`IDENTITY`](Self::IDENTITY), [`FORWARD_ONLY`](Self::FORWARD_ONLY),
    /// [`INVERSE_ONLY`](Self::INVERSE_ONLY) or [`BOTH`](Self::BOTH).
    pub kind: u32,
    /// Joint of each letter of a pose: index + 1 of the first such joint, or zero.
    pub joint_of: [u8; 12],
    /// Context that is passed to the functions.
    pub ctx: *const c_void,
    /// Computes a pose from joint positions. On entry, `pose` holds the last pose as a first guess.
    pub forward: Option<
        unsafe extern "C" fn(*const c_void, joints: *const f64, n: usize, pose: *mut f64) -> Status,
    >,
    /// Computes joint positions from a pose. On entry, `joints` holds the last positions as a first
    /// guess.
    pub inverse: Option<
        unsafe extern "C" fn(*const c_void, pose: *const f64, joints: *mut f64, n: usize) -> Status,
    >,
    /// Since minor 2: number of kinematics types that can be selected. 0 and 1 mean a single type.
    pub types: u32,
    /// Since minor 2: writes all solutions for a pose to `into`, `n` joint positions each, at most
    /// `room` of them. Returns the number of solutions, or the reason why there is none. Slow; not
    /// for realtime.
    pub solutions: Option<
        unsafe extern "C" fn(
            *const c_void,
            pose: *const f64,
            into: *mut f64,
            n: usize,
            room: usize,
        ) -> Status,
    >,
    /// Since minor 2: selects a kinematics type, from 0. Returns `EINVAL` if it does not exist. The
    /// relation between poses and joints changes from then on.
    pub switch: Option<unsafe extern "C" fn(*const c_void, to: u32) -> Status>,
    /// Since minor 10: context for the calls of one worker, if the functions may not run with
    /// [`ctx`](Self::ctx) in two threads at once. Null if they may: `ctx` then serves all threads.
    pub worker_ctx: *const c_void,
}

impl Kinematics {
    /// Kind: joints are axes.
    pub const IDENTITY: u32 = 1;
    /// Kind: only from joint positions to a pose.
    pub const FORWARD_ONLY: u32 = 2;
    /// Kind: only from a pose to joint positions.
    pub const INVERSE_ONLY: u32 = 3;
    /// Kind: both directions.
    pub const BOTH: u32 = 4;

    /// The solution is at a singularity: others are equally valid, or joints would need unbounded
    /// speed to continue.
    pub const SINGULAR: Status = Status(1);
    /// The pose cannot be reached, or no pose has these joint positions.
    pub const UNREACHABLE: Status = Status(-33);
    /// The solution is beyond the limits of a joint of the arm.
    pub const BEYOND_LIMITS: Status = Status(-34);
    /// The solution is not determined at this pose.
    pub const UNDETERMINED: Status = Status(-35);
    /// An iterative search did not converge.
    pub const NOT_FOUND: Status = Status(-62);
    /// The dimensions of the machine are invalid.
    pub const GEOMETRY: Status = Status(-71);
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Kinematics {
    const MIN: usize = offset_of!(Self, types);
}

/// Function table of the service `interlock`, version 1: the e-stop state for realtime threads.
///
/// Motion is allowed only while [`Interlock::state`] returns exactly [`Interlock::RELEASED`]. A
/// missing function and every other value mean e-stop.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Interlock {
    /// `size_of::<Interlock>()` at compile time.
    pub size: u32,
    /// Zero; reserved for later versions.
    pub flags: u32,
    /// Context that is passed to the function.
    pub ctx: *const c_void,
    /// Realtime, reentrant. Returns the bits [`Interlock::NOT_COMMANDED`] and
    /// [`Interlock::ENABLED`].
    pub state: Option<unsafe extern "C" fn(*const c_void) -> u32>,
}

impl Interlock {
    /// Set while no e-stop is commanded.
    pub const NOT_COMMANDED: u32 = 1;
    /// Set while the e-stop chain is closed: `emc-enable-in` is TRUE.
    pub const ENABLED: u32 = 2;
    /// The only value that does not mean e-stop.
    pub const RELEASED: u32 = Self::NOT_COMMANDED | Self::ENABLED;
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Interlock {
    const MIN: usize = size_of::<Self>();
}

/// Function table of the service `iocontrol`, version 1: e-stop, coolant and tool changer for
/// workers. Its functions may be called from several threads at once, never from a realtime thread.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct IoControl {
    /// `size_of::<IoControl>()` at compile time.
    pub size: u32,
    /// Zero; reserved for later versions.
    pub flags: u32,
    /// Context that is passed to the functions.
    pub ctx: *const c_void,
    /// Begins a request and returns its number, or 0 if too many requests wait or it is unknown.
    pub request: Option<unsafe extern "C" fn(*const c_void, *const IoCommand) -> u64>,
    /// Writes the oldest result that was not taken yet, and returns 1; 0 without one. One user takes
    /// the results of all.
    pub result: Option<unsafe extern "C" fn(*const c_void, *mut IoOutcome) -> u32>,
    /// Writes the current state.
    pub state: Option<unsafe extern "C" fn(*const c_void, *mut IoStatus)>,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for IoControl {
    const MIN: usize = size_of::<Self>();
}

/// A request to the service `iocontrol`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct IoCommand {
    /// `size_of::<IoCommand>()` at compile time.
    pub size: u32,
    /// Kind: 1 e-stop, 2 reset, 3 prepare, 4 change, 5 set tool, 6 coolant, 7 abort.
    pub kind: u32,
    /// Number of the tool.
    pub tool: i32,
    /// Pocket of the tool.
    pub pocket: i32,
    /// Place in the tool table.
    pub index: i32,
    /// Outputs that change: 1 mist, 2 flood, 4 lubrication.
    pub changes: u32,
    /// Values of these outputs.
    pub values: u32,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for IoCommand {
    const MIN: usize = size_of::<Self>();
}

/// Result of a request to the service `iocontrol`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct IoOutcome {
    /// Number of the request.
    pub id: u64,
    /// Reason of its failure, static; empty if it succeeded.
    pub why: Str,
}

/// State that the service `iocontrol` reports.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct IoStatus {
    /// Bits of [`Interlock`] for the e-stop.
    pub interlock: u32,
    /// Outputs that are on: 1 mist, 2 flood, 4 lubrication; and 8 while there is enough lubricant.
    pub outputs: u32,
    /// Number of the tool in the spindle.
    pub tool: i32,
    /// Pocket that it came from.
    pub pocket: i32,
    /// Number of the prepared tool.
    pub prepared: i32,
    /// Zero; reserved for later versions.
    pub reserved: i32,
}

//! Tables of functions that one plugin offers to others.

use crate::{Free, Record, Status, Str, Use};
use core::{ffi::c_void, mem::offset_of};

/// A table of functions for other plugins. Ownership as in [`FunctSpec`](crate::FunctSpec).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ServiceSpec {
    /// `size_of::<ServiceSpec>()` as compiled.
    pub size: u32,
    /// The version of the table; versions must be equal.
    pub version: u32,
    /// What it offers, such as `kinematics`; one provider a name.
    pub name: Str,
    /// The table: `#[repr(C)]`, its layout fixed by name and version.
    pub table: *const c_void,
    /// Its state.
    pub state: *mut c_void,
    /// How to free the state.
    pub free: Option<Free>,
    /// What its functions touch: whoever calls them takes these edges over.
    pub uses: *const Use,
    /// How many.
    pub n_uses: usize,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for ServiceSpec {
    const MIN: usize = size_of::<Self>();
}

/// The table of the service `kinematics`, version 1. A pose is x y z a b c u v w.
///
/// Its functions answer with [`Status::OK`], with [`Kinematics::SINGULAR`], which is an answer as
/// well, or with why there is none; without an answer they leave what they were to fill as it was.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Kinematics {
    /// `size_of::<Kinematics>()` as compiled.
    pub size: u32,
    /// How many joints it moves.
    pub joints: u32,
    /// 1 identity, 2 forward only, 3 inverse only, 4 both.
    pub kind: u32,
    /// Which joint follows each letter of a pose: index + 1 of the first, or zero.
    pub joint_of: [u8; 12],
    /// Passed to the functions.
    pub ctx: *const c_void,
    /// From joint positions to a pose. `pose` holds the last pose as a first guess.
    pub forward: Option<
        unsafe extern "C" fn(*const c_void, joints: *const f64, n: usize, pose: *mut f64) -> Status,
    >,
    /// From a pose to joint positions. `joints` holds the last positions as a first guess.
    pub inverse: Option<
        unsafe extern "C" fn(*const c_void, pose: *const f64, joints: *mut f64, n: usize) -> Status,
    >,
    /// Since minor 2: how many types of kinematics there are to switch between; 0 and 1: one.
    pub types: u32,
    /// Since minor 2: every way to reach a pose, `n` joint positions each, at most `room` of them
    /// into `into`. How many ways there are, or why there is none. Takes its time: not for
    /// realtime.
    pub solutions: Option<
        unsafe extern "C" fn(
            *const c_void,
            pose: *const f64,
            into: *mut f64,
            n: usize,
            room: usize,
        ) -> Status,
    >,
    /// Since minor 2: switches to a type, from 0; `EINVAL` when there is none. Poses and joints
    /// follow each other in the new way from then on.
    pub switch: Option<unsafe extern "C" fn(*const c_void, to: u32) -> Status>,
}

impl Kinematics {
    /// An answer at a singular place: others are as good, or joints would have to move without
    /// bounds to go on.
    pub const SINGULAR: Status = Status(1);
    /// The pose cannot be reached, or no pose has these joints.
    pub const UNREACHABLE: Status = Status(-33);
    /// Beyond what a joint of the arm can do.
    pub const BEYOND_LIMITS: Status = Status(-34);
    /// No answer is determined there.
    pub const UNDETERMINED: Status = Status(-35);
    /// A search for the answer did not come to an end.
    pub const NOT_FOUND: Status = Status(-62);
    /// Lengths or points of the machine make no sense.
    pub const GEOMETRY: Status = Status(-71);
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Kinematics {
    const MIN: usize = offset_of!(Self, types);
}

/// The table of the service `interlock`, version 1: the e-stop as a realtime thread reads it.
///
/// Motion is allowed only while [`Interlock::state`] answers exactly [`Interlock::RELEASED`]. A
/// missing function, and every other answer, means e-stop.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Interlock {
    /// `size_of::<Interlock>()` as compiled.
    pub size: u32,
    /// Zero; for later versions.
    pub flags: u32,
    /// Passed to the function.
    pub ctx: *const c_void,
    /// Realtime, reentrant. The bits [`Interlock::NOT_COMMANDED`] and [`Interlock::ENABLED`].
    pub state: Option<unsafe extern "C" fn(*const c_void) -> u32>,
}

impl Interlock {
    /// No e-stop is commanded.
    pub const NOT_COMMANDED: u32 = 1;
    /// The chain of e-stop contacts is closed: `emc-enable-in` is TRUE.
    pub const ENABLED: u32 = 2;
    /// The only answer that is no e-stop.
    pub const RELEASED: u32 = Self::NOT_COMMANDED | Self::ENABLED;
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Interlock {
    const MIN: usize = size_of::<Self>();
}

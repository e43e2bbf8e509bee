//! The service `homing`: a module homes the joints in the place of the motion controller.

use crate::{Host, Record, Status, Str};
use core::ffi::c_void;

/// Function table of the service `homing`, version 1. Its functions are those of LinuxCNC's homing
/// modules. `open` runs while the motion controller is created; the others run in its realtime
/// function only.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Homing {
    /// `size_of::<Homing>()` at compile time.
    pub size: u32,
    /// Zero; reserved for later versions.
    pub flags: u32,
    /// Context that is passed to the functions.
    pub ctx: *const c_void,
    /// Name of the module, live as long as the service.
    pub name: Str,
    /// Prepares the module for this number of joints, of which the last `extra` are not moved by the
    /// kinematics. The module creates its pins with `host`, which is that of the caller.
    pub open: Option<
        unsafe extern "C" fn(
            *const c_void,
            host: *const Host,
            period: f64,
            joints: u32,
            extra: u32,
        ) -> Status,
    >,
    /// Sets the homing settings of a joint; with `update` only offset, position and sequence, which
    /// alone have changed.
    pub configure:
        Option<unsafe extern "C" fn(*const c_void, joint: u32, *const HomingSettings, update: u32)>,
    /// Writes the record of a joint.
    pub put: Option<unsafe extern "C" fn(*const c_void, joint: u32, *const HomingJoint)>,
    /// Reads the record of a joint, as the module has left it.
    pub take: Option<unsafe extern "C" fn(*const c_void, joint: u32, *mut HomingJoint)>,
    /// Calls a function of the module, one of [`homing_call`], for a joint, or for all with a number
    /// below 0. [`homing_call::RUN`] returns 1 while the module homes any joint; otherwise 0.
    pub call: Option<unsafe extern "C" fn(*const c_void, what: u32, joint: i32) -> u32>,
    /// Returns the bits of [`homing_state`] of a joint.
    pub state: Option<unsafe extern "C" fn(*const c_void, joint: u32) -> u32>,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Homing {
    const MIN: usize = size_of::<Self>();
}

/// Functions of a homing module that [`Homing::call`] calls.
pub mod homing_call {
    /// Reads the module's input pins.
    pub const READ_PINS: u32 = 1;
    /// Runs one cycle of homing.
    pub const RUN: u32 = 2;
    /// Writes the module's output pins.
    pub const WRITE_PINS: u32 = 3;
    /// Begins to home a joint, or all with -1.
    pub const HOME: u32 = 4;
    /// Aborts homing of a joint.
    pub const CANCEL: u32 = 5;
    /// Unhomes a joint, all with -1, or those with a volatile home with -2, while the machine is off.
    pub const UNHOME_OFF: u32 = 6;
    /// The same while the machine is on, in free mode.
    pub const UNHOME_FREE: u32 = 7;
}

/// Bits of the state of a joint that a homing module reports.
pub mod homing_state {
    /// The joint is homed.
    pub const HOMED: u32 = 1;
    /// The joint is being homed.
    pub const HOMING: u32 = 2;
    /// The module has nothing to do with the joint.
    pub const IDLE: u32 = 4;
    /// The joint waits for the index of its encoder.
    pub const INDEX_WAIT: u32 = 8;
    /// The index has not come yet.
    pub const INDEX_ENABLE: u32 = 16;
    /// The module wants the joint's lock open.
    pub const UNLOCK: u32 = 32;
}

/// Bits of [`HomingJoint::flags`], the first eight with LinuxCNC's values.
pub mod homing_flags {
    /// The amplifier is on.
    pub const ENABLED: u32 = 1;
    /// The joint takes part.
    pub const ACTIVE: u32 = 2;
    /// The joint is at rest.
    pub const IN_POSITION: u32 = 4;
    /// The joint switched the machine off.
    pub const ERROR: u32 = 8;
    /// The joint is at its positive limit switch.
    pub const AT_MAX: u32 = 16;
    /// The joint is at its negative limit switch.
    pub const AT_MIN: u32 = 32;
    /// The following error is beyond its limit.
    pub const FERROR: u32 = 64;
    /// The amplifier has a fault.
    pub const FAULT: u32 = 128;
    /// The joint's lock exists and is open.
    pub const UNLOCKED: u32 = 1 << 16;
    /// The joint has a lock.
    pub const HAS_LOCK: u32 = 1 << 17;
    /// A command jogs the joint.
    pub const KB_JOG: u32 = 1 << 18;
    /// A wheel jogs the joint.
    pub const WHEEL_JOG: u32 = 1 << 19;
    /// The joint's own planner is on.
    pub const PLANNER_ON: u32 = 1 << 20;
    /// The joint's own planner moves it.
    pub const PLANNER_ACTIVE: u32 = 1 << 21;
}

/// Homing settings of a joint, in machine units and seconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomingSettings {
    /// `size_of::<HomingSettings>()` at compile time.
    pub size: u32,
    /// Bits, with LinuxCNC's values: 1 ignore limits, 2 index, 4 shared switch, 8 lock, 16 absolute
    /// encoder, 32 no second homing, 64 no final move, 128 the index does not reset the encoder.
    pub flags: u32,
    /// Order among the joints; below 0 together with others.
    pub sequence: i32,
    /// 1 if the joint becomes unhomed as the machine goes off.
    pub volatile_home: u32,
    /// Position assigned to the switch or the index.
    pub offset: f64,
    /// Position of the final move.
    pub home: f64,
    /// Velocity of the final move; 0 for the joint's own.
    pub final_velocity: f64,
    /// Velocity towards the switch.
    pub search_velocity: f64,
    /// Velocity of the slow search.
    pub latch_velocity: f64,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for HomingSettings {
    const MIN: usize = size_of::<Self>();
}

/// Joint as a homing module sees it, in machine units and seconds. Of its changes, those of
/// `pos_cmd`, `pos_fb`, `motor_offset` and the planner count.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HomingJoint {
    /// `size_of::<HomingJoint>()` at compile time.
    pub size: u32,
    /// Bits of [`homing_flags`].
    pub flags: u32,
    /// Upper soft limit.
    pub max_limit: f64,
    /// Lower soft limit.
    pub min_limit: f64,
    /// Highest position of a jog.
    pub max_jog: f64,
    /// Lowest position of a jog.
    pub min_jog: f64,
    /// Velocity limit.
    pub max_velocity: f64,
    /// Acceleration limit.
    pub max_acceleration: f64,
    /// Following error allowed at any velocity.
    pub min_ferror: f64,
    /// Following error allowed at the velocity limit.
    pub max_ferror: f64,
    /// Backlash.
    pub backlash: f64,
    /// Commanded position.
    pub pos_cmd: f64,
    /// Commanded velocity.
    pub vel_cmd: f64,
    /// Commanded acceleration.
    pub acc_cmd: f64,
    /// Target of the correction.
    pub backlash_corr: f64,
    /// Correction that is applied.
    pub backlash_filt: f64,
    /// Velocity of the correction.
    pub backlash_vel: f64,
    /// Last command of the motor.
    pub motor_pos_cmd: f64,
    /// Position of the motor, measured.
    pub motor_pos_fb: f64,
    /// Measured position.
    pub pos_fb: f64,
    /// Following error.
    pub ferror: f64,
    /// Following error that is allowed at the current velocity.
    pub ferror_limit: f64,
    /// Position of the motor at which the joint is at zero.
    pub motor_offset: f64,
    /// Target of the joint's own planner.
    pub target: f64,
    /// Velocity limit of the planner.
    pub planner_velocity: f64,
    /// Acceleration limit of the planner.
    pub planner_acceleration: f64,
    /// Position of the planner.
    pub planner_pos: f64,
    /// Velocity of the planner.
    pub planner_vel: f64,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for HomingJoint {
    const MIN: usize = size_of::<Self>();
}

//! Records of the service `motion`: commands, answers, and the function table.

use crate::{Record, Status, Str};
use core::ffi::c_void;

/// A command for the motion controller: the arguments of a `motion.*` command as numbers.
///
/// Each kind reads the fields that its text command has as arguments, and ignores all others.
/// Lengths are in machine units, angles in degrees, times in seconds.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionCommand {
    /// `size_of::<MotionCommand>()` at compile time.
    pub size: u32,
    /// Kind, of [`motion_kind`].
    pub kind: u32,
    /// Origin of the command, of [`motion_source`].
    pub source: u32,
    /// Line of the program, for messages and status.
    pub line: u32,
    /// Bits of [`motion_flags`].
    pub flags: u32,
    /// Letters of `pose` that are given: bit 0 for x, bit 8 for w.
    pub letters: u32,
    /// Number of the joint, axis, spindle or output.
    pub index: u32,
    /// Mode: of the path (0 stop, 1 exact, 2 blend), of the machine (0 free, 1 teleop, 2
    /// coordinated), or the direction of an orientation (0 shorter, 1 clockwise, 2
    /// counterclockwise).
    pub mode: u32,
    /// Meaning of `speed` for a move: 0 the default velocity, 1 rapid, 2 a velocity in units/s, 3
    /// the duration of the whole move in s.
    pub speed_kind: u32,
    /// Extent of a jog: 0 until it is stopped, 1 by the distance `value`, 2 to the position `value`.
    pub extent: u32,
    /// Additional full turns of an arc.
    pub count: u32,
    /// Setting that [`motion_kind::CONFIGURE`] changes: its place in
    /// [`motion_setting::NAMES`], from 0.
    pub setting: u32,
    /// Target, or tool offset: x y z a b c u v w. Only the letters in `letters` count.
    pub pose: [f64; 9],
    /// Centre of an arc in x y z.
    pub center: [f64; 3],
    /// Direction of an arc's axis; zero means z.
    pub normal: [f64; 3],
    /// Zero.
    pub reserved: [f64; 4],
    /// Velocity or duration of a move, as `speed_kind` says; velocity of a jog; turns per minute of
    /// a spindle.
    pub speed: f64,
    /// Acceleration along the path; 0 means as allowed.
    pub acceleration: f64,
    /// Tolerance of a blend; infinity or a negative number means none.
    pub tolerance: f64,
    /// Largest distance of a joined path from its lines; 0 joins nothing.
    pub cam_tolerance: f64,
    /// Factor: an override, or the speed of a tap's way back.
    pub scale: f64,
    /// Distance or position of a jog, angle of an orientation, value of an output or setting, or override of rapid moves.
    pub value: f64,
    /// Travel per turn of the spindle `index` for motion bound to a spindle.
    pub pitch: f64,
    /// Stop epoch in which the order was given, of [`Motion::epoch`]; 0 means that of the moment at which it arrives. An
    /// order from before a stop begins nothing.
    pub epoch: u64,
}

impl MotionCommand {
    /// Returns a command of this kind with zeros in all other fields.
    pub const fn new(kind: u32) -> Self {
        Self {
            size: crate::size::<Self>(),
            kind,
            source: motion_source::TASK,
            line: 0,
            flags: 0,
            letters: 0,
            index: 0,
            mode: 0,
            speed_kind: 0,
            extent: 0,
            count: 0,
            setting: 0,
            pose: [0.0; 9],
            center: [0.0; 3],
            normal: [0.0; 3],
            reserved: [0.0; 4],
            speed: 0.0,
            acceleration: 0.0,
            tolerance: 0.0,
            cam_tolerance: 0.0,
            scale: 0.0,
            value: 0.0,
            pitch: 0.0,
            epoch: 0,
        }
    }
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for MotionCommand {
    const MIN: usize = core::mem::offset_of!(Self, epoch);
}

/// Kinds of commands. Each has the arguments of the text command `motion.NAME`.
pub mod motion_kind {
    /// Names of the text commands; the place of a name is its kind.
    pub const NAMES: &[&str] = &[
        "",
        "enable",
        "disable",
        "mode",
        "home",
        "unhome",
        "jog",
        "jog-stop",
        "abort",
        "spindle",
        "spindle-orient",
        "feed",
        "override-limits",
        "move",
        "arc",
        "probe",
        "pause",
        "resume",
        "step",
        "reverse",
        "forward",
        "tool-offset",
        "digital-out",
        "analog-out",
        "configure",
        "tap",
    ];
    /// Switches the machine on.
    pub const ENABLE: u32 = 1;
    /// Switches the machine off.
    pub const DISABLE: u32 = 2;
    /// Changes the mode: `mode`.
    pub const MODE: u32 = 3;
    /// Homes the joint `index`, or all.
    pub const HOME: u32 = 4;
    /// Forgets the place of the joint `index`, or of all.
    pub const UNHOME: u32 = 5;
    /// Jogs the joint or axis `index`: `speed`, `extent`, `value`.
    pub const JOG: u32 = 6;
    /// Brakes the jog of the joint or axis `index`, or all.
    pub const JOG_STOP: u32 = 7;
    /// Brakes everything and discards the moves that wait.
    pub const ABORT: u32 = 8;
    /// Changes the spindle `index`: `speed`, `scale`, brake, each if its flag is set.
    pub const SPINDLE: u32 = 9;
    /// Turns the spindle `index` to the angle `value` with the direction `mode`.
    pub const ORIENT: u32 = 10;
    /// Changes the scaling of feeds, `scale`, of rapid moves, `value`, and adaptive and hold of both, each if its flag
    /// is set.
    pub const FEED: u32 = 11;
    /// Lets a joint be jogged off a limit switch.
    pub const OVERRIDE_LIMITS: u32 = 12;
    /// Moves in a straight line to `pose`. With a `pitch` it follows the spindle `index`.
    pub const MOVE: u32 = 13;
    /// Moves along an arc to `pose`.
    pub const ARC: u32 = 14;
    /// Moves towards `pose` until the probe changes.
    pub const PROBE: u32 = 15;
    /// Brakes along the path and holds.
    pub const PAUSE: u32 = 16;
    /// Goes on along the path.
    pub const RESUME: u32 = 17;
    /// Goes on to the next move.
    pub const STEP: u32 = 18;
    /// Goes back along the path.
    pub const REVERSE: u32 = 19;
    /// Goes forward again.
    pub const FORWARD: u32 = 20;
    /// Sets the tool offset `pose` when the motion gets there.
    pub const TOOL_OFFSET: u32 = 21;
    /// Sets the digital output `index`.
    pub const DIGITAL_OUT: u32 = 22;
    /// Sets the analog output `index` to `value`.
    pub const ANALOG_OUT: u32 = 23;
    /// Changes one setting of the joint, axis or spindle `index`, or of coordinated moves.
    pub const CONFIGURE: u32 = 24;
    /// Taps rigidly to `pose` and back, with the spindle `index` and its `pitch`.
    pub const TAP: u32 = 25;
}

/// Bits of [`MotionCommand::flags`].
pub mod motion_flags {
    /// An arc turns clockwise around its normal.
    pub const CLOCKWISE: u32 = 1;
    /// A probe move ends where the probe loses its contact.
    pub const AWAY: u32 = 1 << 1;
    /// A probe move that finds nothing does not fail.
    pub const OPTIONAL: u32 = 1 << 2;
    /// An output changes when the motion gets there.
    pub const SYNC: u32 = 1 << 3;
    /// Value of a digital output, or of a setting that is true or false.
    pub const ON: u32 = 1 << 4;
    /// `index` is the number of an axis: 0 for x, 8 for w.
    pub const AXIS: u32 = 1 << 5;
    /// `index` is the number of a joint.
    pub const JOINT: u32 = 1 << 6;
    /// `index` is the number of a spindle, for [`CONFIGURE`](super::motion_kind::CONFIGURE).
    pub const SPINDLE: u32 = 1 << 7;
    /// All joints.
    pub const ALL: u32 = 1 << 8;
    /// `speed` of a spindle is given.
    pub const HAS_SPEED: u32 = 1 << 9;
    /// `scale` is given.
    pub const HAS_SCALE: u32 = 1 << 10;
    /// The brake of a spindle is given.
    pub const HAS_BRAKE: u32 = 1 << 11;
    /// The brake closes.
    pub const BRAKE: u32 = 1 << 12;
    /// [`ADAPTIVE`] is given.
    pub const HAS_ADAPTIVE: u32 = 1 << 13;
    /// The pin `motion.adaptive-feed` counts.
    pub const ADAPTIVE: u32 = 1 << 14;
    /// [`HOLD`] is given.
    pub const HAS_HOLD: u32 = 1 << 15;
    /// The pin `motion.feed-hold` counts.
    pub const HOLD: u32 = 1 << 16;
    /// The centre of an arc is given in x, y, z: three bits from here.
    pub const CENTER_X: u32 = 1 << 17;
    /// Motion bound to a spindle: the velocity follows the spindle, without its phase.
    pub const VELOCITY_MODE: u32 = 1 << 20;
    /// `value` is given: the override of rapid moves.
    pub const HAS_RAPID: u32 = 1 << 21;
    /// Motion bound to a spindle at constant surface speed, with [`VELOCITY_MODE`]: its turns at the move are not known
    /// before, and the feed is not compared with the limits beforehand.
    pub const SURFACE: u32 = 1 << 22;
    /// All bits.
    pub const ALL_BITS: u32 = (1 << 23) - 1;
}

/// Origins of motion.
pub mod motion_source {
    /// The owner of the token: a program or MDI.
    pub const TASK: u32 = 0;
    /// An operator at the machine: text commands, `halui`, jog wheels. Needs no token.
    pub const LOCAL: u32 = 1;
    /// A remote operator. Local sources end its motion, so it needs no token.
    pub const REMOTE: u32 = 2;
}

/// Settings that [`CONFIGURE`](motion_kind::CONFIGURE) changes.
pub mod motion_setting {
    /// Arguments of `motion.configure` with a number or a bit; the place of a name is its code.
    pub const NAMES: &[&str] = &[
        "min-limit",
        "max-limit",
        "max-velocity",
        "max-acceleration",
        "ferror",
        "min-ferror",
        "home",
        "home-offset",
        "home-sequence",
        "backlash",
        "max-jerk",
        "offset-av-ratio",
        "default-velocity",
        "max-feed-override",
        "min-forward-velocity",
        "max-forward-velocity",
        "min-reverse-velocity",
        "max-reverse-velocity",
    ];
}

/// Length of the text of a [`MotionAnswer`] in bytes.
pub const MOTION_TEXT: usize = 232;

/// Answer of the service `motion`. The caller sets `size`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MotionAnswer {
    /// `size_of::<MotionAnswer>()` at compile time, of the caller.
    pub size: u32,
    /// Number of bytes of `text`.
    pub len: u32,
    /// Token, or number of the command.
    pub id: u64,
    /// Reason of a refusal or failure, in UTF-8.
    pub text: [u8; MOTION_TEXT],
}

impl MotionAnswer {
    /// The empty answer.
    pub const EMPTY: Self =
        Self { size: crate::size::<Self>(), len: 0, id: 0, text: [0; MOTION_TEXT] };
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for MotionAnswer {
    const MIN: usize = size_of::<Self>();
}

/// Function table of the service `motion`, version 1.
///
/// Its functions are for tasks, workers and commands, never for a realtime thread. They may be
/// called from several threads at once, and they never wait for motion. A pointer must be null or
/// point to a live value for the duration of the call; a null pointer is refused with
/// [`Status::EINVAL`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// `size_of::<Motion>()` at compile time.
    pub size: u32,
    /// Zero; reserved for later versions.
    pub flags: u32,
    /// Context that is passed to the functions.
    pub ctx: *const c_void,
    /// Makes the caller the owner of motion; the answer holds its token. Returns
    /// [`Status::EBUSY`] while motion has another owner. An owner that asks again under the same
    /// name gets a new token, and the old one is void.
    pub acquire:
        Option<unsafe extern "C" fn(*const c_void, name: Str, answer: *mut MotionAnswer) -> Status>,
    /// Ends the ownership, and the claim with it.
    pub release: Option<unsafe extern "C" fn(*const c_void, token: u64) -> Status>,
    /// Begins or ends the claim: while it lasts, no other source may begin motion, even if nothing
    /// moves.
    pub claim: Option<unsafe extern "C" fn(*const c_void, token: u64, on: u32) -> Status>,
    /// Returns the number of moves for which there is room.
    pub room: Option<unsafe extern "C" fn(*const c_void) -> u32>,
    /// Sends a command; the answer holds its number. A token of zero sends it as a local source, or as
    /// a remote one if the command says so.
    /// Returns [`Status::EAGAIN`] if there is no room, [`Status::EBUSY`] for a void token, or
    /// [`Status::EINVAL`] for a command that is refused.
    pub push: Option<
        unsafe extern "C" fn(
            *const c_void,
            token: u64,
            command: *const MotionCommand,
            answer: *mut MotionAnswer,
        ) -> Status,
    >,
    /// Reports how a command has ended: [`Status::OK`] if it is complete, [`Status::EAGAIN`] while
    /// it is in progress, [`Status::EINVAL`] with the reason if it failed, [`Status::ENOENT`] if it
    /// ended too long ago or never existed.
    pub poll:
        Option<unsafe extern "C" fn(*const c_void, id: u64, answer: *mut MotionAnswer) -> Status>,
    /// Copies the first `n` words of the record of the latest cycle, always of one cycle, and
    /// returns their number in the record. Later versions append words.
    pub status: Option<unsafe extern "C" fn(*const c_void, words: *mut u64, n: u32) -> u32>,
    /// Reads the setting that a command of the kind [`CONFIGURE`](motion_kind::CONFIGURE) names.
    /// Returns [`Status::EINVAL`] if there is no such setting.
    pub setting: Option<
        unsafe extern "C" fn(
            *const c_void,
            command: *const MotionCommand,
            value: *mut f64,
        ) -> Status,
    >,
    /// Returns the stop epoch: the number of stops so far in the high half, of pauses in the low one. It rises when a stop is
    /// commanded, and in the cycle in which motion stops by itself, and is never 0.
    pub epoch: Option<unsafe extern "C" fn(*const c_void) -> u64>,
}

// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for Motion {
    const MIN: usize = core::mem::offset_of!(Self, epoch);
}

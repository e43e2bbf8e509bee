//! The record that the snapshot `motion.status` and the service `motion` share.

use crate::Plain;

/// Number of joints in the record.
const JOINTS: usize = 16;
/// Number of spindles in the record.
const SPINDLES: usize = 8;
/// Number of analog inputs and outputs in the record.
const ANALOG: usize = 8;

/// State of the machine at the end of a cycle. Positions are in machine units, velocities in units
/// per second. Joints beyond the last have zeros.
///
/// Later versions append fields.
#[derive(Clone, Copy, Debug, PartialEq, Plain)]
pub struct MotionStatus {
    /// Number of cycles of motion-controller, from 1.
    pub cycle: u64,
    /// Machine time at the start of the cycle, in nanoseconds.
    pub time_ns: i64,
    /// True while the machine is on.
    pub enabled: bool,
    /// Mode: 0 free, 1 teleop, 2 coordinated.
    pub mode: u32,
    /// True while nothing moves and nothing waits to move.
    pub in_position: bool,
    /// True if all joints that take part are homed.
    pub all_homed: bool,
    /// True while a joint is being homed.
    pub homing: bool,
    /// True while a joint or an axis jogs.
    pub jogging: bool,
    /// Velocity along the path, or of all jogs together.
    pub velocity: f64,
    /// Programmed velocity of the current move within the machine's limits, without override.
    pub requested_velocity: f64,
    /// Distance to the end of the current move.
    pub distance_to_go: f64,
    /// Product of all factors of the feed, without rapid moves.
    pub feed_scale: f64,
    /// Feed override; rapid moves have their own.
    pub feed_override: f64,
    /// True while adaptive feed counts.
    pub adaptive_feed: bool,
    /// True while motion.feed-hold counts.
    pub feed_hold: bool,
    /// True while the axes have left a paused path.
    pub away: bool,
    /// True while the path is paused.
    pub paused: bool,
    /// True while the path runs backwards.
    pub reverse: bool,
    /// Number of the current move, from 1; 0 without one.
    pub segment: u32,
    /// Line of the program of the current move.
    pub line: u32,
    /// Kind of the current move: 0 none, 1 rapid, 2 feed, 3 arc, 5 probing.
    pub motion_type: u32,
    /// Number of moves that have not ended.
    pub queue: u32,
    /// True after a move was refused, until the next one is accepted.
    pub move_refused: bool,
    /// True while a probe move is in progress.
    pub probing: bool,
    /// State of motion.probe-input.
    pub probe_input: bool,
    /// True if the last probe move found its place.
    pub probe_found: bool,
    /// Pose in the cycle in which the probe changed, as measured.
    pub probe_measured: [f64; 9],
    /// Pose in the cycle in which the probe changed, as commanded.
    pub probe_commanded: [f64; 9],
    /// Tool offset that the program uses.
    pub tool_offset: [f64; 9],
    /// Digital inputs for programs, a bit for each.
    pub digital_in: u64,
    /// Digital outputs of programs, a bit for each.
    pub digital_out: u64,
    /// First analog inputs for programs.
    pub analog_in: [f64; ANALOG],
    /// First analog outputs of programs.
    pub analog_out: [f64; ANALOG],
    /// Number of spindles.
    pub spindles: u32,
    /// Commanded speeds of the spindles, in turns per minute, without override.
    pub spindle_speed: [f64; SPINDLES],
    /// Overrides of the spindles.
    pub spindle_override: [f64; SPINDLES],
    /// True while all spindles that turn are at speed.
    pub at_speed: bool,
    /// Commanded pose: x y z a b c u v w.
    pub pose: [f64; 9],
    /// Number of joints.
    pub joints: u32,
    /// True for a joint that is configured and takes part.
    pub joint_active: [bool; JOINTS],
    /// Commanded positions of the joints.
    pub joint_position: [f64; JOINTS],
    /// Positions of the joints as their encoders report them.
    pub joint_feedback: [f64; JOINTS],
    /// Commanded velocities of the joints.
    pub joint_velocity: [f64; JOINTS],
    /// True for a joint that is homed.
    pub joint_homed: [bool; JOINTS],
    /// True for a joint that switched the machine off.
    pub joint_error: [bool; JOINTS],
    /// True for a joint at its negative limit switch.
    pub joint_at_min: [bool; JOINTS],
    /// True for a joint at its positive limit switch.
    pub joint_at_max: [bool; JOINTS],
    /// Pose as the encoders report it: x y z a b c u v w.
    pub pose_feedback: [f64; 9],
    /// Distance of each axis to the end of the current move.
    pub axis_to_go: [f64; 9],
    /// Origin of the last motion: 0 the owner of the service, 1 local, 2 remote.
    pub source: u32,
    /// True while the owner of the service keeps other sources from beginning motion.
    pub claimed: bool,
    /// True in e-stop, if the machine has an interlock.
    pub estop: bool,
    /// True while limit switches do not switch the machine off.
    pub overriding_limits: bool,
    /// True while a joint is beyond its soft limit.
    pub on_soft_limit: bool,
    /// State of motion.jog-inhibit.
    pub jog_inhibit: bool,
    /// True for a spindle whose brake is closed.
    pub spindle_brake: [bool; SPINDLES],
    /// True for a spindle that is at its speed, or does not turn.
    pub spindle_at_speed: [bool; SPINDLES],
    /// Joints at or below their lower soft limit, a bit for each.
    pub joints_below: u32,
    /// Joints at or above their upper soft limit, a bit for each.
    pub joints_above: u32,
    /// Highest velocity of coordinated moves, as configured.
    pub max_velocity: f64,
    /// Number of machine units per millimetre.
    pub units_per_mm: f64,
    /// True for a joint that is being homed.
    pub joint_homing: [bool; JOINTS],
    /// True for a joint whose amplifier has a fault.
    pub joint_fault: [bool; JOINTS],
    /// Lower limits of the joints, as configured.
    pub joint_min_limit: [f64; JOINTS],
    /// Upper limits of the joints, as configured.
    pub joint_max_limit: [f64; JOINTS],
    /// Orientation of the spindles: 0 none, 1 oriented, 2 in progress.
    pub spindle_orient_state: [u32; SPINDLES],
    /// Faults that ended the last orientation of the spindles; 0 is none.
    pub spindle_orient_fault: [i32; SPINDLES],
    /// Error inputs of the machine, a bit for each.
    pub misc_errors: u64,
    /// Override of rapid moves.
    pub rapid_override: f64,
    /// Stop epoch: number of stops so far in the high half, of pauses in the low one. An order from before a stop is refused.
    pub epoch: u64,
    /// True if the machine reads the e-stop of iocontrol; without it, `motion.disable` is its e-stop.
    pub interlock: bool,
    /// Wait of motion at rest, as a number of the task's table of waits; 0 is none.
    pub wait: u32,
    /// Spindle that it waits for.
    pub wait_number: i32,
    /// Machine time in nanoseconds since which it waits.
    pub wait_since_ns: i64,
    /// True if the wait ends by itself: the measured speed of the spindle still changes towards its command.
    pub wait_ends: bool,
    /// Spindles that somebody else has stopped after they were turned for the path, or for a program, a bit for each. No feed runs until a resume.
    pub spindles_stopped: u32,
    /// Spindles whose pin inhibit is TRUE, a bit for each.
    pub spindles_inhibited: u32,
    /// Distance travelled along the current move.
    pub travelled: f64,
}

impl MotionStatus {
    /// Version, which increases when a field is appended.
    pub const VERSION: u32 = 7;
}

//! Realtime. The snapshot `motion.status`: the state of the machine in each cycle, as a whole.

use crate::{
    path::Parked,
    pins::Lists,
    setup::{MAX_JOINTS, MAX_SPINDLES, put},
    state::State,
};
use hal_component::{Builder, Error, In, Plain, Snapshot};

/// Number of analog inputs and outputs in the snapshot.
const ANALOG: usize = 8;

/// Version of [`MotionStatus`].
const VERSION: u32 = 2;

/// State of the machine at the end of a cycle. Positions are in machine units, velocities in units
/// per second. Joints beyond the last have zeros.
#[derive(Clone, Copy, Debug, PartialEq, Plain)]
pub(crate) struct MotionStatus {
    /// Number of cycles of motion-controller, from 1.
    pub(crate) cycle: u64,
    /// Machine time at the start of the cycle, in nanoseconds.
    pub(crate) time_ns: i64,
    /// True while the machine is on.
    pub(crate) enabled: bool,
    /// Mode: 0 free, 1 teleop, 2 coordinated.
    pub(crate) mode: u32,
    /// True while nothing moves and nothing waits to move.
    pub(crate) in_position: bool,
    /// True if all joints that take part are homed.
    pub(crate) all_homed: bool,
    /// True while a joint is being homed.
    pub(crate) homing: bool,
    /// True while a joint or an axis jogs.
    pub(crate) jogging: bool,
    /// Velocity along the path, or of all jogs together.
    pub(crate) velocity: f64,
    /// Programmed velocity of the current move within the machine's limits, without override.
    pub(crate) requested_velocity: f64,
    /// Distance to the end of the current move.
    pub(crate) distance_to_go: f64,
    /// Product of all factors of the feed.
    pub(crate) feed_scale: f64,
    /// Feed override.
    pub(crate) feed_override: f64,
    /// True while adaptive feed counts.
    pub(crate) adaptive_feed: bool,
    /// True while motion.feed-hold counts.
    pub(crate) feed_hold: bool,
    /// True while the axes have left a paused path.
    pub(crate) away: bool,
    /// True while the path is paused.
    pub(crate) paused: bool,
    /// True while the path runs backwards.
    pub(crate) reverse: bool,
    /// Number of the current move, from 1; 0 without one.
    pub(crate) segment: u32,
    /// Line of the program of the current move.
    pub(crate) line: u32,
    /// Kind of the current move: 0 none, 1 rapid, 2 feed, 3 arc, 5 probing.
    pub(crate) motion_type: u32,
    /// Number of moves that have not ended.
    pub(crate) queue: u32,
    /// True after a move was refused, until the next one is accepted.
    pub(crate) move_refused: bool,
    /// True while a probe move is in progress.
    pub(crate) probing: bool,
    /// State of motion.probe-input.
    pub(crate) probe_input: bool,
    /// True if the last probe move found its place.
    pub(crate) probe_found: bool,
    /// Pose in the cycle in which the probe changed, as measured.
    pub(crate) probe_measured: [f64; 9],
    /// Pose in the cycle in which the probe changed, as commanded.
    pub(crate) probe_commanded: [f64; 9],
    /// Tool offset that the program uses.
    pub(crate) tool_offset: [f64; 9],
    /// Digital inputs for programs, a bit for each.
    pub(crate) digital_in: u64,
    /// Digital outputs of programs, a bit for each.
    pub(crate) digital_out: u64,
    /// First analog inputs for programs.
    pub(crate) analog_in: [f64; ANALOG],
    /// First analog outputs of programs.
    pub(crate) analog_out: [f64; ANALOG],
    /// Number of spindles.
    pub(crate) spindles: u32,
    /// Commanded speeds of the spindles, in turns per minute, without override.
    pub(crate) spindle_speed: [f64; MAX_SPINDLES],
    /// Overrides of the spindles.
    pub(crate) spindle_override: [f64; MAX_SPINDLES],
    /// True while all spindles that turn are at speed.
    pub(crate) at_speed: bool,
    /// Commanded pose: x y z a b c u v w.
    pub(crate) pose: [f64; 9],
    /// Number of joints.
    pub(crate) joints: u32,
    /// True for a joint that is configured and takes part.
    pub(crate) joint_active: [bool; MAX_JOINTS],
    /// Commanded positions of the joints.
    pub(crate) joint_position: [f64; MAX_JOINTS],
    /// Positions of the joints as their encoders report them.
    pub(crate) joint_feedback: [f64; MAX_JOINTS],
    /// Commanded velocities of the joints.
    pub(crate) joint_velocity: [f64; MAX_JOINTS],
    /// True for a joint that is homed.
    pub(crate) joint_homed: [bool; MAX_JOINTS],
    /// True for a joint that switched the machine off.
    pub(crate) joint_error: [bool; MAX_JOINTS],
    /// True for a joint at its negative limit switch.
    pub(crate) joint_at_min: [bool; MAX_JOINTS],
    /// True for a joint at its positive limit switch.
    pub(crate) joint_at_max: [bool; MAX_JOINTS],
}

/// Creates the snapshot.
pub(crate) fn open(b: &mut Builder<'_>) -> Result<Snapshot<MotionStatus>, Error> {
    let doc = "State of the machine at the end of each cycle of motion-controller.";
    b.snapshot("motion.status", VERSION, doc)
}

impl MotionStatus {
    /// Returns the state of the machine in a cycle that began at this machine time.
    pub(crate) fn of(s: &State, lists: &Lists, cycle: u64, time_ns: i64, velocity: f64) -> Self {
        let current = s.path.current();
        let homing = s.is_homing();
        let mut status = Self {
            cycle,
            time_ns,
            enabled: s.enabled,
            mode: s.mode as u32,
            in_position: s.is_idle(),
            all_homed: s.is_all_homed(),
            homing,
            jogging: !homing && s.is_jogging(),
            velocity,
            requested_velocity: s.path.feeds().0,
            distance_to_go: s.path.distance_to_go(),
            feed_scale: s.feed.net,
            feed_override: s.feed.scale,
            adaptive_feed: s.feed.adaptive,
            feed_hold: s.feed.hold,
            away: s.path.parked() != Parked::No,
            paused: s.path.is_paused(),
            reverse: s.path.is_reverse(s.feed.reverse),
            segment: current.map_or(0, |c| c.id),
            line: current.map_or(0, |c| c.line),
            motion_type: current.map_or(0, |c| c.kind as u32),
            queue: u32::try_from(s.path.depth()).unwrap_or(0),
            move_refused: s.coord_error,
            probing: s.path.is_probing(),
            probe_input: s.inputs.probe,
            probe_found: s.probe.found,
            probe_measured: s.probe.measured,
            probe_commanded: s.probe.commanded,
            tool_offset: s.tool_offset,
            digital_in: bits(lists.digital_in.iter().map(In::get)),
            digital_out: bits(s.digital_out.iter().copied()),
            analog_in: [0.0; ANALOG],
            analog_out: [0.0; ANALOG],
            spindles: u32::try_from(s.spindles.len()).unwrap_or(0),
            spindle_speed: [0.0; MAX_SPINDLES],
            spindle_override: [0.0; MAX_SPINDLES],
            at_speed: s.at_speed,
            pose: s.pose,
            joints: u32::try_from(s.joints.len()).unwrap_or(0),
            joint_active: [false; MAX_JOINTS],
            joint_position: [0.0; MAX_JOINTS],
            joint_feedback: [0.0; MAX_JOINTS],
            joint_velocity: [0.0; MAX_JOINTS],
            joint_homed: [false; MAX_JOINTS],
            joint_error: [false; MAX_JOINTS],
            joint_at_min: [false; MAX_JOINTS],
            joint_at_max: [false; MAX_JOINTS],
        };
        for (place, pin) in status.analog_in.iter_mut().zip(&lists.analog_in) {
            *place = pin.get();
        }
        for (place, value) in status.analog_out.iter_mut().zip(&s.analog_out) {
            *place = *value;
        }
        let speeds = status.spindle_speed.iter_mut().zip(&mut status.spindle_override);
        for ((speed, scale), spindle) in speeds.zip(&s.spindles) {
            *speed = spindle.speed();
            *scale = spindle.scale;
        }
        for (n, joint) in s.joints.iter().enumerate() {
            put(&mut status.joint_active, n, joint.active);
            put(&mut status.joint_position, n, joint.pos_cmd);
            put(&mut status.joint_feedback, n, joint.pos_fb);
            put(&mut status.joint_velocity, n, joint.vel_cmd);
            put(&mut status.joint_homed, n, joint.homing.homed);
            put(&mut status.joint_error, n, joint.error);
            put(&mut status.joint_at_min, n, joint.inputs.at_min);
            put(&mut status.joint_at_max, n, joint.inputs.at_max);
        }
        status
    }
}

/// Returns bits as a number, the first as the lowest.
fn bits(list: impl Iterator<Item = bool>) -> u64 {
    list.take(64).enumerate().fold(0, |sum, (n, bit)| sum | u64::from(bit) << n)
}

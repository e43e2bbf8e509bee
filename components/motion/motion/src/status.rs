//! Realtime. The snapshot `motion.status`: the state of the machine in each cycle, as a whole.

use crate::{setup::MAX_JOINTS, state::State};
use hal_component::{Builder, Error, Plain, Snapshot};

/// Version of [`MotionStatus`].
const VERSION: u32 = 1;

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
    /// Distance to the end of the current move.
    pub(crate) distance_to_go: f64,
    /// Product of all factors of the feed.
    pub(crate) feed_scale: f64,
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
    pub(crate) fn of(s: &State, cycle: u64, time_ns: i64, velocity: f64) -> Self {
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
            distance_to_go: s.path.distance_to_go(),
            feed_scale: s.feed.net,
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

fn put<T>(list: &mut [T; MAX_JOINTS], n: usize, value: T) {
    if let Some(place) = list.get_mut(n) {
        *place = value;
    }
}

//! Realtime. The snapshot `motion.status`: the state of the machine in each cycle, as a whole.

use crate::{
    path::Parked,
    pins::Lists,
    setup::{MAX_JOINTS, MAX_SPINDLES, put},
    state::State,
};
use hal_component::{Builder, Error, In, MotionSource, MotionStatus, Snapshot, motion_source};

/// Number of analog inputs and outputs in the snapshot.
const ANALOG: usize = 8;

/// Creates the snapshot.
pub(crate) fn open(b: &mut Builder<'_>) -> Result<Snapshot<MotionStatus>, Error> {
    let doc = "State of the machine at the end of each cycle of motion-controller.";
    b.snapshot("motion.status", MotionStatus::VERSION, doc)
}

/// Returns the state of the machine in a cycle that began at this machine time.
pub(crate) fn of(
    s: &State,
    lists: &Lists,
    cycle: u64,
    time_ns: i64,
    velocity: f64,
) -> MotionStatus {
    let current = s.path.current();
    let homing = s.is_homing();
    let mut status = MotionStatus {
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
        pose_feedback: s.pose_feedback,
        axis_to_go: s.path.axis_to_go(),
        source: match s.origin.source {
            MotionSource::Task => motion_source::TASK,
            MotionSource::Local => motion_source::LOCAL,
            MotionSource::Remote => motion_source::REMOTE,
        },
        claimed: s.origin.is_claimed(),
        estop: s.inputs.lockout.is_some(),
        overriding_limits: s.overriding,
        on_soft_limit: s.on_soft_limit,
        jog_inhibit: s.inputs.jog_inhibit,
        spindle_brake: [false; MAX_SPINDLES],
        spindle_at_speed: [false; MAX_SPINDLES],
        joints_below: 0,
        joints_above: 0,
        max_velocity: s.traj.max_velocity,
        units_per_mm: s.traj.units_per_mm,
        joint_homing: [false; MAX_JOINTS],
        joint_fault: [false; MAX_JOINTS],
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
    for (n, spindle) in s.spindles.iter().enumerate() {
        put(&mut status.spindle_brake, n, spindle.has_brake());
        put(&mut status.spindle_at_speed, n, spindle.at_speed);
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
        let (below, above) = joint.at_soft_limits();
        status.joints_below |= u32::from(below) << n;
        status.joints_above |= u32::from(above) << n;
        put(&mut status.joint_homing, n, joint.homing.is_under_way());
        put(&mut status.joint_fault, n, joint.inputs.amp_fault);
    }
    status
}

/// Returns bits as a number, the first as the lowest.
fn bits(list: impl Iterator<Item = bool>) -> u64 {
    list.take(64).enumerate().fold(0, |sum, (n, bit)| sum | u64::from(bit) << n)
}

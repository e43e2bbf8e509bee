//! Realtime. The snapshot `motion.status`: the state of the machine in each cycle, as a whole.

use crate::{joint::Joint, path::Parked, pins::Lists, setup::put, state::State};
use hal_component::{
    Builder, Error, In, MotionSource, MotionStatus, Plain, Snapshot, motion_source,
};

/// Creates the snapshot.
pub(crate) fn open(b: &mut Builder<'_>) -> Result<Snapshot<MotionStatus>, Error> {
    let doc = "State of the machine at the end of each cycle of motion-controller.";
    b.snapshot("motion.status", MotionStatus::VERSION, doc)
}

/// Returns a record of a machine of which nothing is known.
pub(crate) fn blank() -> MotionStatus {
    Plain::load(&mut || 0)
}

/// Updates a record to the state of the machine at the end of a cycle; `changed` has a bit for each joint whose state has
/// changed.
pub(crate) fn update(r: &mut MotionStatus, s: &State, lists: &Lists, changed: u32) {
    let current = s.path.current();
    let (homing, jogging) = (s.is_homing(), s.is_jogging());
    r.enabled = s.enabled;
    r.mode = s.mode as u32;
    r.in_position = s.path.is_idle() && !jogging && !homing;
    r.all_homed = s.is_all_homed();
    r.homing = homing;
    r.jogging = !homing && jogging;
    r.requested_velocity = s.path.feeds().0;
    r.distance_to_go = s.path.distance_to_go();
    r.feed_scale = s.feed.net;
    r.feed_override = s.feed.scale;
    r.adaptive_feed = s.feed.adaptive;
    r.feed_hold = s.feed.hold;
    r.away = s.path.parked() != Parked::No;
    r.paused = s.path.is_paused();
    r.reverse = s.path.is_reverse(s.feed.reverse);
    r.segment = current.map_or(0, |c| c.id);
    r.line = current.map_or(0, |c| c.line);
    r.motion_type = current.map_or(0, |c| c.kind as u32);
    r.queue = u32::try_from(s.path.depth()).unwrap_or(0);
    r.move_refused = s.coord_error;
    r.probing = s.path.is_probing();
    r.probe_input = s.inputs.probe;
    r.probe_found = s.probe.found;
    r.probe_measured = s.probe.measured;
    r.probe_commanded = s.probe.commanded;
    r.tool_offset = s.tool_offset;
    r.digital_in = bits(lists.digital_in.iter().map(In::get));
    r.misc_errors = bits(lists.misc_errors.iter().map(In::get));
    r.digital_out = bits(s.digital_out.iter().copied());
    r.at_speed = s.at_speed;
    r.pose = s.pose;
    r.pose_feedback = s.pose_feedback;
    r.axis_to_go = s.path.axis_to_go();
    r.source = match s.origin_in_progress() {
        MotionSource::Task => motion_source::TASK,
        MotionSource::Local => motion_source::LOCAL,
        MotionSource::Remote => motion_source::REMOTE,
    };
    r.claimed = s.origin.is_claimed();
    r.estop = s.inputs.lockout.is_some();
    r.overriding_limits = s.overriding;
    r.on_soft_limit = s.on_soft_limit;
    r.jog_inhibit = s.inputs.jog_inhibit;
    r.max_velocity = s.traj.max_velocity;
    r.units_per_mm = s.traj.units_per_mm;
    for (place, pin) in r.analog_in.iter_mut().zip(&lists.analog_in) {
        *place = pin.get();
    }
    for (place, value) in r.analog_out.iter_mut().zip(&s.analog_out) {
        *place = *value;
    }
    r.spindles = u32::try_from(s.spindles.len()).unwrap_or(0);
    for (n, spindle) in s.spindles.iter().enumerate() {
        put(&mut r.spindle_speed, n, spindle.speed());
        put(&mut r.spindle_override, n, spindle.scale);
        put(&mut r.spindle_brake, n, spindle.has_brake());
        put(&mut r.spindle_at_speed, n, spindle.at_speed);
        let (state, fault) = spindle.orientation();
        put(&mut r.spindle_orient_state, n, state);
        put(&mut r.spindle_orient_fault, n, fault);
    }
    r.joints = u32::try_from(s.joints.len()).unwrap_or(0);
    for (n, joint) in s.joints.iter().enumerate() {
        put(&mut r.joint_position, n, joint.pos_cmd);
        put(&mut r.joint_feedback, n, joint.pos_fb);
        put(&mut r.joint_velocity, n, joint.vel_cmd);
        put(&mut r.joint_min_limit, n, joint.config.min_limit);
        put(&mut r.joint_max_limit, n, joint.config.max_limit);
        if changed >> n & 1 == 1 {
            update_joint(r, n, joint);
        }
    }
}

fn update_joint(r: &mut MotionStatus, n: usize, joint: &Joint) {
    put(&mut r.joint_active, n, joint.active);
    put(&mut r.joint_homed, n, joint.homing.homed);
    put(&mut r.joint_error, n, joint.error);
    put(&mut r.joint_at_min, n, joint.inputs.at_min);
    put(&mut r.joint_at_max, n, joint.inputs.at_max);
    put(&mut r.joint_homing, n, joint.homing.is_under_way());
    put(&mut r.joint_fault, n, joint.inputs.amp_fault);
    let (below, above) = joint.at_soft_limits();
    for (bits, is) in [(&mut r.joints_below, below), (&mut r.joints_above, above)] {
        *bits = *bits & !(1 << n) | u32::from(is) << n;
    }
}

/// Returns bits as a number, the first as the lowest.
fn bits(list: impl Iterator<Item = bool>) -> u64 {
    list.take(64).enumerate().fold(0, |sum, (n, bit)| sum | u64::from(bit) << n)
}

//! Realtime. The snapshot `motion.status`: the state of the machine in each cycle, as a whole.

use crate::{
    guards::interlock::Lockout,
    joint::Joint,
    path::Parked,
    pins::{Lists, Shown, packed},
    setup::{MAX_SPINDLES, put},
    state::State,
};
use hal_component::{
    Builder, Error, In, MotionSource, MotionStatus, Plain, Snapshot, SnapshotReader, Touch, fields,
    motion_source,
};

/// Fields that change in every cycle of a motion. The others are written when one of them has changed.
const MOTION: u128 = fields::<MotionStatus>(&[
    "cycle",
    "time_ns",
    "velocity",
    "requested_velocity",
    "distance_to_go",
    "pose",
    "joint_position",
    "joint_feedback",
    "joint_velocity",
    "pose_feedback",
    "axis_to_go",
    "travelled",
]);

/// The snapshot, its last record, and the values from which its other fields were written last.
#[derive(Debug, Touch)]
pub(crate) struct Status {
    snapshot: Snapshot<MotionStatus>,
    #[state]
    record: MotionStatus,
    #[state]
    state: Shown<7>,
    #[state]
    spindles: [Shown<4>; MAX_SPINDLES],
}

impl Status {
    /// Creates the snapshot, of a machine of which nothing is known.
    pub(crate) fn open(b: &mut Builder<'_>) -> Result<Self, Error> {
        let doc = "State of the machine at the end of each cycle of motion-controller.";
        Ok(Self {
            snapshot: b.snapshot("motion.status", MotionStatus::VERSION, doc)?,
            record: Plain::load(&mut || 0),
            state: Shown::default(),
            spindles: [Shown::default(); MAX_SPINDLES],
        })
    }

    /// Returns a reading end of the snapshot.
    pub(crate) fn reader(&self) -> SnapshotReader<MotionStatus> {
        self.snapshot.reader()
    }

    /// Returns the record of the last cycle.
    pub(crate) const fn record(&self) -> &MotionStatus {
        &self.record
    }

    /// Publishes the state of the machine at the end of a cycle; `changed` has a bit for each joint whose state has
    /// changed.
    pub(crate) fn publish(&mut self, s: &State, lists: &Lists, cycle: Cycle, changed: u32) {
        let is_other = self.has_changed(s, lists) | (changed != 0);
        let r = &mut self.record;
        r.cycle = cycle.number;
        r.time_ns = cycle.time_ns;
        r.velocity = cycle.velocity;
        r.requested_velocity = s.path.feeds().0;
        r.distance_to_go = s.path.distance_to_go();
        r.pose = s.pose;
        r.pose_feedback = s.pose_feedback;
        r.axis_to_go = s.path.axis_to_go();
        r.travelled = s.path.along().0;
        let places = r.joint_position.iter_mut().zip(&mut r.joint_feedback);
        let places = places.zip(&mut r.joint_velocity);
        for (joint, ((position, feedback), velocity)) in s.joints.iter().zip(places) {
            *position = joint.pos_cmd;
            *feedback = joint.pos_fb;
            *velocity = joint.vel_cmd;
        }
        if is_other {
            update(r, s, lists);
            for (n, joint) in s.joints.iter().enumerate().filter(|(n, _)| changed >> n & 1 == 1) {
                update_joint(r, n, joint);
            }
            self.snapshot.set(r);
        } else {
            self.snapshot.set_some::<MOTION>(r);
        }
        #[cfg(all(test, debug_assertions))]
        self.check(s, lists);
    }

    /// Returns whether a value has changed that no field in [`MOTION`] shows, other than those of joints.
    fn has_changed(&mut self, s: &State, lists: &Lists) -> bool {
        let current = s.path.current();
        let state = packed([
            s.is_on(),
            s.path.is_idle(),
            s.axes.iter().any(|axis| axis.teleop.tp.active),
            s.feed.adaptive,
            s.feed.hold,
            s.path.parked() != Parked::No,
            s.path.is_paused(),
            s.path.is_reverse(s.feed.reverse),
            s.coord_error,
            s.path.is_probing(),
            s.inputs.probe,
            s.probe.found,
            s.at_speed,
            s.origin.is_claimed(),
            s.inputs.lockout.is_some_and(Lockout::is_estop),
            s.overriding,
            s.on_soft_limit,
            s.inputs.jog_inhibit,
        ]);
        let kind = current.map_or(0, |c| c.kind as u32);
        let mut changed = self.state.changes([
            state | u64::from(s.mode() as u32) << 32 | u64::from(source(s)) << 48,
            u64::from(current.map_or(0, |c| c.id)) << 32 | u64::from(kind),
            u64::from(current.map_or(0, |c| c.line)) << 32 | s.path.depth() as u64,
            u64::from(s.tool_offsets) << 32 | u64::from(s.probe.number),
            s.epoch,
            u64::from(s.wait.kind as u32) << 32
                | u64::from(s.wait.number.cast_unsigned()) << 8
                | u64::from(s.wait.is_ramp),
            u64::from(s.lost_spindles()) << 32 | u64::from(inhibited(s)),
        ]);
        let r = &self.record;
        changed |= differ(lists.analog_in.iter().map(In::get), &r.analog_in);
        changed |= differ(s.analog_out.iter().copied(), &r.analog_out);
        changed |= bits(lists.digital_in.iter().map(In::get)) != r.digital_in;
        changed |= bits(lists.misc_errors.iter().map(In::get)) != r.misc_errors;
        changed |= bits(s.digital_out.iter().copied()) != r.digital_out;
        let (feed, traj) = (&s.feed, &s.traj);
        let set = [feed.net.feed, feed.scale, feed.rapid, traj.max_velocity, traj.units_per_mm];
        let shown =
            [r.feed_scale, r.feed_override, r.rapid_override, r.max_velocity, r.units_per_mm];
        changed |= differ(set.into_iter(), &shown);
        for (shown, spindle) in self.spindles.iter_mut().zip(&s.spindles) {
            let (orientation, fault) = spindle.orientation();
            changed |= shown.changes([
                packed([spindle.has_brake(), spindle.at_speed]),
                u64::from(orientation) << 32 | u64::from(fault.cast_unsigned()),
                spindle.speed().to_bits(),
                spindle.scale.to_bits(),
            ]);
        }
        changed
    }

    /// Fails if the published record is not what all values give.
    #[cfg(all(test, debug_assertions))]
    fn check(&self, s: &State, lists: &Lists) {
        let mut whole = self.record;
        update(&mut whole, s, lists);
        for (n, joint) in s.joints.iter().enumerate() {
            update_joint(&mut whole, n, joint);
        }
        let words = |record: &MotionStatus| {
            let mut words = [0; MotionStatus::WORDS];
            let mut places = words.iter_mut();
            record.store(&mut |word| {
                if let Some(place) = places.next() {
                    *place = word;
                }
            });
            words
        };
        let published = self.snapshot.reader().get().map(|r| words(&r));
        assert!(published == Some(words(&whole)), "{whole:?}");
    }
}

/// Number of a cycle, its time, and the velocity in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cycle {
    pub(crate) number: u64,
    pub(crate) time_ns: i64,
    pub(crate) velocity: f64,
}

/// Updates the fields that are not in [`MOTION`], without those of the joints.
fn update(r: &mut MotionStatus, s: &State, lists: &Lists) {
    let current = s.path.current();
    let (homing, jogging) = (s.is_homing(), s.is_jogging());
    r.enabled = s.is_on();
    r.mode = s.mode() as u32;
    r.in_position = s.path.is_idle() && !jogging && !homing;
    r.all_homed = s.is_all_homed();
    r.homing = homing;
    r.jogging = !homing && jogging;
    r.feed_scale = s.feed.net.feed;
    r.feed_override = s.feed.scale;
    r.rapid_override = s.feed.rapid;
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
    r.source = source(s);
    r.claimed = s.origin.is_claimed();
    r.estop = s.inputs.lockout.is_some_and(Lockout::is_estop);
    r.overriding_limits = s.overriding;
    r.on_soft_limit = s.on_soft_limit;
    r.jog_inhibit = s.inputs.jog_inhibit;
    r.max_velocity = s.traj.max_velocity;
    r.units_per_mm = s.traj.units_per_mm;
    r.epoch = s.epoch;
    r.interlock = s.has_interlock;
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
    r.wait = s.wait.kind as u32;
    r.wait_number = s.wait.number;
    r.wait_since_ns = s.wait.since_ns;
    r.wait_ends = s.wait.is_ramp;
    r.spindles_stopped = s.lost_spindles();
    r.spindles_inhibited = inhibited(s);
    r.joints = u32::try_from(s.joints.len()).unwrap_or(0);
}

/// Returns the spindles whose pin inhibit is TRUE.
fn inhibited(s: &State) -> u32 {
    let bits = s.spindles.iter().map(|spindle| spindle.inputs.inhibit).enumerate();
    bits.fold(0, |sum, (n, is)| sum | u32::from(is) << n)
}

/// Returns the code of the origin of the last motion.
fn source(s: &State) -> u32 {
    match s.origin_in_progress() {
        MotionSource::Task => motion_source::TASK,
        MotionSource::Local => motion_source::LOCAL,
        MotionSource::Remote => motion_source::REMOTE,
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
    put(&mut r.joint_min_limit, n, joint.config.min_limit);
    put(&mut r.joint_max_limit, n, joint.config.max_limit);
    let (below, above) = joint.at_soft_limits();
    for (bits, is) in [(&mut r.joints_below, below), (&mut r.joints_above, above)] {
        *bits = *bits & !(1 << n) | u32::from(is) << n;
    }
}

/// Returns bits as a number, the first as the lowest.
fn bits(list: impl Iterator<Item = bool>) -> u64 {
    list.take(64).enumerate().fold(0, |sum, (n, bit)| sum | u64::from(bit) << n)
}

/// Returns whether a value has other bits than the one that is shown in its place.
fn differ(values: impl Iterator<Item = f64>, shown: &[f64]) -> bool {
    values.zip(shown).fold(0, |bits, (a, b)| bits | a.to_bits() ^ b.to_bits()) != 0
}

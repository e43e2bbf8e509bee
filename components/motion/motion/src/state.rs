//! Realtime. State of the machine, and its modes.

use crate::{
    axis::Axis,
    commands::command::Joints,
    commands::config::TrajConfig,
    commands::refusal::Refusal,
    compensation::Tables,
    guards::interlock::Lockout,
    guards::last_jump::LastJump,
    guards::stop_line::{self, StopLine},
    guards::stops::Stops,
    guards::watch::WatchCounters,
    homing::{module::ModuleHoming, sequence::HomingSequence},
    jogger::TravelLimits,
    joint::Joint,
    names::Names,
    path::{Parked, Path},
    setup::{MAX_JOINTS, Places, Setup},
    source::Origin,
    spindle::Spindle,
    switch::Switch,
    waits::WaitInProgress,
};
use hal_component::{HomingRef, KinematicsKind, KinematicsRef, Messages, Pose, TicketHandle, Wait};
use hal_safety::{Event, SafetyMachine};
use hal_trajectory::Scales;
use libm::fabs;
use std::sync::Arc;

/// Inputs of this cycle that are common to all joints.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Inputs {
    pub(crate) lockout: Option<Lockout>,
    pub(crate) enable: bool,
    pub(crate) jog_inhibit: bool,
    pub(crate) homing_inhibit: bool,
    pub(crate) jog_stop: bool,
    pub(crate) jog_stop_immediate: bool,
    pub(crate) probe: bool,
}

/// Result of the last probe move.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ProbeResult {
    /// Number of poses so far.
    pub(crate) number: u32,
    /// True if the probe has changed.
    pub(crate) found: bool,
    /// Pose in that cycle, as measured.
    pub(crate) measured: Pose,
    /// Pose in that cycle, as commanded.
    pub(crate) commanded: Pose,
}

/// Scaling of feeds and of rapid moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Feed {
    /// Feed override.
    pub(crate) scale: f64,
    /// Override of rapid moves.
    pub(crate) rapid: f64,
    pub(crate) adaptive: bool,
    pub(crate) hold: bool,
    /// True if a negative adaptive feed runs the path backwards.
    pub(crate) reverse: bool,
    /// Products of all factors in this cycle.
    pub(crate) net: Scales,
    /// Last products above 0 of override and adaptive feed.
    pub(crate) last: Scales,
    /// Hold of a pin in this cycle.
    pub(crate) held: Option<Wait>,
    /// Factors of a retract from a thread, for which holds do not count: `last`, or 0 while the feed is inhibited.
    pub(crate) retract: Scales,
}

/// State of motion, without the pins.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) kinematics: KinematicsRef,
    pub(crate) names: Names,
    pub(crate) switch: Switch,
    pub(crate) say: Messages,
    pub(crate) joints: Vec<Joint>,
    /// True if a joint has a lock.
    pub(crate) has_locks: bool,
    /// Screw errors of all joints.
    pub(crate) tables: Tables,
    pub(crate) axes: Vec<Axis>,
    /// Fraction of velocity and acceleration that each joint has for moves.
    pub(crate) planning_fractions: [f64; MAX_JOINTS],
    pub(crate) spindles: Vec<Spindle>,
    pub(crate) digital_out: Vec<bool>,
    pub(crate) analog_out: Vec<f64>,
    /// True if all spindles that turn are at speed.
    pub(crate) at_speed: bool,
    pub(crate) traj: TrajConfig,
    pub(crate) feed: Feed,
    pub(crate) path: Path,
    pub(crate) probe: ProbeResult,
    pub(crate) tool_offset: Pose,
    /// Number of tool offsets so far.
    pub(crate) tool_offsets: u32,
    pub(crate) origin: Origin,
    /// Safety machine, which decides on power, orders and stops.
    pub(crate) machine: SafetyMachine,
    /// Cause of the ramp in progress.
    pub(crate) ramp_cause: &'static str,
    /// Joints whose place is known only by what they were commanded.
    pub(crate) open_loop: Joints,
    /// Servo period in seconds.
    pub(crate) dt: f64,
    /// Commanded pose of the axes.
    pub(crate) pose: Pose,
    /// Pose of the axes as the encoders report it.
    pub(crate) pose_feedback: Pose,
    pub(crate) inputs: Inputs,
    /// True if limit switches do not switch the machine off until a jog has ended.
    pub(crate) overriding: bool,
    pub(crate) override_moved: bool,
    pub(crate) coord_error: bool,
    pub(crate) on_soft_limit: bool,
    pub(crate) enable_ticket: Option<TicketHandle>,
    /// Joints that are being homed.
    pub(crate) homing: Option<HomingSequence>,
    /// Homing module of the user, in the place of the controller's own homing.
    pub(crate) module: Option<Box<ModuleHoming>>,
    /// Ticket that is done when all motion has ended.
    pub(crate) stop_ticket: Option<TicketHandle>,
    pub(crate) last_jump: Arc<LastJump>,
    pub(crate) watch: WatchCounters,
    pub(crate) stops: Stops,
    /// Stops that are commanded, and the stop epoch.
    pub(crate) line: Arc<StopLine>,
    /// Stop epoch at the end of this cycle.
    pub(crate) epoch: u64,
    /// True if the epoch has risen for this cycle: a stop was commanded, or motion has stopped by itself.
    pub(crate) has_risen: bool,
    /// True if the machine has an interlock.
    pub(crate) has_interlock: bool,
    /// Machine time at the start of the cycle, in nanoseconds.
    pub(crate) now_ns: i64,
    /// Reason why the axes do not move, for as long as it applies.
    pub(crate) stays: Option<&'static str>,
    pub(crate) wait: WaitInProgress,
}

impl State {
    pub(crate) fn new(
        setup: &Setup,
        kinematics: KinematicsRef,
        homing: Option<HomingRef>,
        path: Path,
        say: Messages,
        stops: Stops,
    ) -> Self {
        let first_extra = setup.joints - setup.extra_joints;
        let joint = |n| Joint::new(n >= first_extra, setup.unlock_mask >> n & 1 == 1);
        Self {
            names: Names::of(&kinematics),
            kinematics,
            switch: Switch::default(),
            say,
            joints: (0..setup.joints).map(joint).collect(),
            has_locks: setup.unlock_mask != 0,
            tables: Tables::default(),
            axes: (0..9).map(|_| Axis::default()).collect(),
            planning_fractions: [1.0; MAX_JOINTS],
            spindles: vec![Spindle::default(); setup.spindles],
            digital_out: vec![false; setup.digital_out.len()],
            analog_out: vec![0.0; setup.analog_out.len()],
            at_speed: true,
            traj: TrajConfig::default(),
            feed: Feed {
                scale: 1.0,
                rapid: 1.0,
                adaptive: false,
                hold: true,
                reverse: false,
                net: Scales::FULL,
                last: Scales::HOLD,
                held: None,
                retract: Scales::HOLD,
            },
            path,
            probe: ProbeResult::default(),
            tool_offset: [0.0; 9],
            tool_offsets: 0,
            origin: Origin::default(),
            machine: SafetyMachine::OFF,
            ramp_cause: "",
            open_loop: Joints::MAX,
            dt: 0.0,
            pose: [0.0; 9],
            pose_feedback: [0.0; 9],
            inputs: Inputs::default(),
            overriding: false,
            override_moved: false,
            coord_error: false,
            on_soft_limit: false,
            enable_ticket: None,
            homing: None,
            module: homing.map(ModuleHoming::new).map(Box::new),
            stop_ticket: None,
            last_jump: Arc::default(),
            watch: WatchCounters::default(),
            stops,
            line: Arc::default(),
            epoch: 0,
            has_risen: false,
            has_interlock: false,
            now_ns: 0,
            stays: None,
            wait: WaitInProgress::default(),
        }
    }

    /// Raises the stop epoch, once in a cycle: motion stops by itself.
    pub(crate) fn raise_epoch(&mut self) {
        if !core::mem::replace(&mut self.has_risen, true) {
            self.line.raise(stop_line::Stop::Off);
        }
    }

    /// Notes an e-stop or a fall of `motion.enable`, also while the machine is off: nothing that was ordered before begins
    /// after it.
    pub(crate) fn note_stops(&mut self, before: &Inputs) {
        let is_locked = before.lockout.is_none() && self.inputs.lockout.is_some();
        if is_locked || before.enable && !self.inputs.enable {
            self.tell(Event::Cut, "");
        }
    }

    pub(crate) fn active(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|j| j.active)
    }

    pub(crate) fn is_all_homed(&self) -> bool {
        self.active().all(|j| j.homing.homed)
    }

    pub(crate) fn is_homing(&self) -> bool {
        self.joints.iter().any(|j| j.homing.is_under_way()) || self.is_module_asked()
    }

    pub(crate) fn is_jogging(&self) -> bool {
        self.joints.iter().any(|j| j.free.tp.active) || self.axes.iter().any(|a| a.teleop.tp.active)
    }

    /// Returns whether nothing moves and nothing waits to move.
    pub(crate) fn is_idle(&self) -> bool {
        self.path.is_idle() && !self.is_jogging() && !self.is_homing()
    }

    /// Resets all planners to the positions of the joints.
    pub(crate) fn sync(&mut self, why: &'static str) {
        if self.path.parked() == Parked::No {
            self.path.leave();
        }
        for joint in &mut self.joints {
            joint.free.reset(joint.pos_cmd, why);
        }
        self.find_pose();
        for (axis, pos) in self.axes.iter_mut().zip(self.pose) {
            axis.teleop.reset(pos, why);
        }
    }

    /// Computes the pose of the joints; returns false if there is none, and then keeps the last one.
    pub(crate) fn find_pose(&mut self) -> bool {
        let places = self.places();
        let mut pose = self.pose;
        let found = self.kinematics.forward(&places, &mut pose).is_ok()
            && pose.iter().all(|p| p.is_finite());
        if found {
            self.pose = pose;
            for (place, axis) in self.pose.iter_mut().zip(&self.axes) {
                *place -= axis.offset.tp.pos;
            }
        }
        found
    }

    /// Computes the pose that the encoders report. Where the kinematics have none, it is the commanded pose.
    pub(crate) fn find_feedback(&mut self) {
        let mut places = [0.0; MAX_JOINTS];
        for (place, joint) in places.iter_mut().zip(&self.joints) {
            *place = joint.pos_fb;
        }
        let mut pose = self.pose_feedback;
        let found = self.kinematics.forward(&places, &mut pose).is_ok()
            && pose.iter().all(|p| p.is_finite());
        self.pose_feedback = if found { pose } else { self.pose };
    }

    /// Returns the commanded positions of the joints.
    pub(crate) fn places(&self) -> Places {
        let mut places = [0.0; MAX_JOINTS];
        for (place, joint) in places.iter_mut().zip(&self.joints) {
            *place = joint.pos_cmd;
        }
        places
    }

    /// Returns the limits of a jog of an axis, reduced by its offset's fraction, and its travel by the offset: a jog ends where
    /// both together are at the limit, because an offset may be too slow to give way.
    pub(crate) fn jog_limits(&self, letter: usize) -> Result<TravelLimits, Refusal> {
        let mut limits = self.axis_limits(letter)?;
        if let Some(axis) = self.axes.get(letter) {
            limits.max_vel *= 1.0 - axis.config.offset_fraction;
            limits.max_acc *= 1.0 - axis.config.offset_fraction;
            limits.max_jerk *= 1.0 - axis.config.offset_fraction;
            let (lowest, highest) = axis.offset.tp.extent(self.dt);
            if lowest < 0.0 {
                limits.min -= lowest;
            }
            if highest > 0.0 {
                limits.max -= highest;
            }
        }
        Ok(limits)
    }

    /// Returns the jerk limit of an axis: its own, and of an axis that is not rotary that of a path.
    pub(crate) fn axis_jerk(&self, letter: usize) -> f64 {
        let own = self.axes.get(letter).map_or(f64::INFINITY, |a| a.config.max_jerk);
        let is_rotary = (3..6).contains(&letter);
        if is_rotary || own < self.traj.max_jerk { own } else { self.traj.max_jerk }
    }

    /// Returns the limits of an axis: its own, narrowed by those of its joints.
    pub(crate) fn axis_limits(&self, letter: usize) -> Result<TravelLimits, Refusal> {
        let (Some(axis), Some(pos)) = (self.axes.get(letter), self.pose.get(letter)) else {
            return Err(NO_JOINT);
        };
        let c = &axis.config;
        let mut limits = TravelLimits {
            min: c.min_limit,
            max: c.max_limit,
            max_vel: c.max_velocity,
            max_acc: c.max_acceleration,
            max_jerk: self.axis_jerk(letter),
        };
        let mut beside = self.pose;
        if let Some(place) = beside.get_mut(letter) {
            *place += BESIDE;
        }
        let (mut here, mut there) = (self.places(), self.places());
        if self.kinematics.inverse(&self.pose, &mut here).is_err()
            || self.kinematics.inverse(&beside, &mut there).is_err()
        {
            return Err(Refusal::new("cannot jog: the kinematics cannot go there"));
        }
        let identity = self.kinematics.kind() == KinematicsKind::Identity;
        let mut moves = false;
        for (n, (joint, (here, there))) in
            self.joints.iter().zip(here.iter().zip(&there)).enumerate()
        {
            let mut slope = (there - here) / BESIDE;
            if joint.extra || fabs(slope) < 1e-9 {
                continue;
            }
            if identity {
                slope = 1.0;
            }
            moves = true;
            if !joint.active {
                return Err(Refusal::joint(
                    "a joint of this axis is not configured",
                    "cannot jog: joint {} is not configured",
                    n,
                ));
            }
            if joint.lock.is_closed() {
                return Err(Refusal::joint(
                    "cannot jog: a joint of this axis is locked",
                    "cannot jog: joint {} is locked",
                    n,
                ));
            }
            limits.narrow(&joint.jog_limits(), *here, *pos, slope);
        }
        if moves { Ok(limits) } else { Err(NO_JOINT) }
    }
}

/// Step of the numerical derivative of joints with respect to an axis, in units.
const BESIDE: f64 = 1e-3;

const NO_JOINT: Refusal = Refusal::new("cannot jog: no joint follows this axis");

//! Realtime. Coordinated mode: the exchange between the machine and its path, probing, and the return to a paused
//! path.

use super::{Drive, Parked, order::PathSetup};
use crate::{
    commands::command::Run,
    commands::refusal::Refusal,
    jogger::By,
    setup::put,
    state::{ProbeResult, State},
};
use hal_component::{MotionSource, Pose};
use hal_safety::{Event, Resume, Stop};

impl State {
    /// Runs a cycle of coordinated mode.
    pub(crate) fn coord(&mut self, dt: f64) {
        if self.path.is_wanted() {
            let setup = self.path_setup();
            self.path.begin(setup);
        }
        let before = self.pose;
        let (scales, retract) = self.held_scales();
        let pace = self.follow_spindle(dt);
        let drive = Drive {
            dt,
            scales,
            retract,
            retract_tops: self.top_speeds(retract.feed),
            reverse: self.feed.reverse,
            tops: self.top_speeds(scales.feed),
            may_begin: self.at_speed,
            probe: self.inputs.probe,
            pace,
        };
        if let Some(pose) = self.path.step(drive) {
            self.pose = pose;
        }
        if self.path.take_probed() {
            self.keep_probed(&before);
        }
        if let Some(why) = self.path.take_failed() {
            self.say_of_path(why);
        }
        while let Some(output) = self.path.due() {
            self.set_output(output);
        }
        if let Some(why) = self.path.take_refused() {
            self.coord_error = true;
            self.say_of_path(why);
        }
        if let Err(why) = self.place(&before, dt) {
            self.path.clear(why);
            self.coord_error = true;
            self.hold(before, why, dt);
        } else if self.on_soft_limit && self.is_offset().0 && self.path.goes_on() {
            const WHY: &str = "an external offset takes a joint beyond its limit: the move ends";
            self.path.abort_with(Refusal::new(WHY));
            self.say.error(WHY, &[]);
        }
    }

    /// Tells the operator why a move has failed. The owner of motion learns it from the move, and tells it with the line.
    pub(super) fn say_of_path(&self, why: Refusal) {
        if self.path_source() != MotionSource::Task {
            why.say(&self.say);
        }
    }

    /// Keeps the pose at which the probe changed: as measured in this cycle, and as commanded for it.
    fn keep_probed(&mut self, commanded: &Pose) {
        let mut places = self.places();
        for (place, joint) in places.iter_mut().zip(&self.joints) {
            *place = joint.pos_fb;
        }
        let mut measured = *commanded;
        // Without an answer, the commanded pose stands for both.
        let _solved = self.kinematics.forward(&places, &mut measured);
        let number = self.probe.number.wrapping_add(1);
        self.probe = ProbeResult { number, found: true, measured, commanded: *commanded };
    }

    /// Ends the pause of a path, or sends the axes back to one that they have left.
    pub(crate) fn resume(&mut self, resume: Resume) -> Result<(), Refusal> {
        let place = match (resume, self.path.parked()) {
            (Resume::Path, _) => return self.path.run(Run::Resume),
            (Resume::Return, Parked::Away(place)) => place,
            _ => return Ok(()),
        };
        for (n, to) in place.iter().enumerate() {
            if self.pose.get(n).is_some_and(|at| at.to_bits() != to.to_bits()) {
                let limits = self.jog_limits(n)?;
                if let Some(axis) = self.axes.get_mut(n) {
                    axis.teleop.set_target(*to, limits.max_vel, &limits, By::Command, None);
                }
            }
        }
        self.path.set_parked(Parked::Returns(place));
        Ok(())
    }

    /// Goes on along the path once the axes are back on it. Axes that were stopped on their way stay paused.
    pub(crate) fn end_return(&mut self) {
        match self.path.parked() {
            Parked::No | Parked::Away(_) => {}
            Parked::Returns(_) if self.is_jogging() => {}
            Parked::Returns(place) => {
                let dt = self.dt;
                let mut axes = self.axes.iter().zip(self.pose.iter().zip(&place));
                let is_back = axes.all(|(axis, (at, to))| {
                    libm::fabs(at - to) <= BACK + axis.teleop.tp.deadband(dt)
                });
                self.path.set_parked(if is_back {
                    Parked::Back(place)
                } else {
                    Parked::Away(place)
                });
            }
            Parked::Back(_) => {
                self.path.set_parked(Parked::No);
                let facts = self.facts();
                // The path stays as it is.
                self.machine.on(Event::Back, &facts);
                self.path.resume_soon();
            }
        }
    }

    /// A probe that trips during a jog or homing ends it.
    pub(crate) fn trip_probe(&mut self) {
        let (homing, jog) = ("the probe tripped during homing", "the probe tripped during a jog");
        let why = if self.is_homing() { homing } else { jog };
        if self.tell(Event::Probe, why).stop != Stop::None {
            self.say.error(why, &[]);
        }
    }

    /// Returns place and limits of the machine for the planner.
    fn path_setup(&self) -> PathSetup {
        let mut setup = PathSetup {
            period: self.dt,
            start: self.pose,
            places: self.places(),
            max_override: self.traj.planned_override(),
            exact_tolerance: EXACT_MM * self.traj.units_per_mm,
            path_velocity: self.traj.max_velocity,
            path_jerk: self.traj.max_jerk,
            ..PathSetup::NONE
        };
        for (n, joint) in self.joints.iter().enumerate() {
            if !joint.active || joint.extra {
                continue;
            }
            let c = &joint.config;
            let fraction = self.planning_fractions.get(n).copied().unwrap_or(1.0);
            put(&mut setup.joint_active, n, true);
            if joint.homing.homed {
                put(&mut setup.joint_min, n, c.min_limit);
                put(&mut setup.joint_max, n, c.max_limit);
            }
            put(&mut setup.joint_velocity, n, c.max_velocity * fraction);
            put(&mut setup.joint_acceleration, n, c.max_acceleration * fraction);
            put(&mut setup.joint_jerk, n, c.max_jerk * fraction);
        }
        for (n, axis) in self.axes.iter().enumerate() {
            let (c, fraction) = (&axis.config, 1.0 - axis.config.offset_fraction);
            put(&mut setup.axis_min, n, c.min_limit);
            put(&mut setup.axis_max, n, c.max_limit);
            put(&mut setup.axis_velocity, n, c.max_velocity * fraction);
            put(&mut setup.axis_acceleration, n, c.max_acceleration * fraction);
            put(&mut setup.axis_jerk, n, self.axis_jerk(n) * fraction);
        }
        setup
    }
}

/// Distance from a path at which axes count as back on it, in units, beside the deadband of their planners; the first cycle
/// on the path closes it.
const BACK: f64 = 2e-6;

/// Distance from the path in exact mode, in millimetres.
const EXACT_MM: f64 = 2e-3;

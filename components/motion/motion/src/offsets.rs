//! Realtime. External offsets of all axes: their limits, and the limits that they leave to moves.

use crate::{
    axis, commands::command::Mode, commands::refusal::Refusal, jogger::TravelLimits, pins::Pins,
    setup::MAX_JOINTS, state::State,
};
use hal_component::{KinematicsKind, Pose};
use libm::fabs;

impl State {
    /// Reads the requests from the pins, and moves the offsets.
    pub(crate) fn offsets(&mut self, pins: &Pins, dt: f64) {
        let mut all = self.axes.iter().zip(&pins.axes);
        if all.all(|(axis, pins)| {
            let has_share = axis.config.offset_fraction > 0.0;
            !has_share && axis.offset.rests_at_zero(pins.eoffset_counts)
        }) {
            return;
        }
        let in_axes = self.is_on() && self.mode() != Mode::Free;
        let allowed = in_axes && self.is_all_homed();
        for n in 0..self.axes.len() {
            let Some(pins) = pins.axes.get(n) else { continue };
            let Some(axis) = self.axes.get_mut(n) else { continue };
            let has_share = axis.config.offset_fraction > 0.0;
            if !has_share && axis.offset.rests_at_zero(pins.eoffset_counts) {
                continue;
            }
            axis.offset.ask(&axis::offset(pins), allowed && has_share);
            let limits = if in_axes { self.offset_limits(n) } else { None };
            let is_stopping = self.is_stopping();
            let Some(axis) = self.axes.get_mut(n) else { continue };
            match limits {
                Some(_) if is_stopping => axis.offset.brake(dt),
                Some(limits) => axis.offset.step(&limits, dt),
                // An applied offset does not vanish at once while the machine is on.
                None if in_axes => axis.offset.set(axis.offset.tp.pos),
                None => axis.offset.set(0.0),
            }
        }
    }

    /// Returns the limits of an offset: its travel, and its fraction of the axis's velocity and acceleration.
    fn offset_limits(&self, n: usize) -> Option<TravelLimits> {
        let axis = self.axes.get(n)?;
        let fraction = axis.config.offset_fraction;
        if fraction <= 0.0 {
            return None;
        }
        // At rest and without a request, nothing is computed.
        if axis.offset.is_unused() {
            return Some(TravelLimits::default());
        }
        let at = *self.pose.get(n)?;
        // The offset may not take the travel that a jog in progress still needs.
        let is_jogged = axis.teleop.is_jog();
        let (lowest, highest) = if is_jogged { axis.teleop.tp.extent(self.dt) } else { (at, at) };
        let limits = self.axis_limits(n).ok()?;
        Some(TravelLimits {
            min: limits.min - lowest,
            max: limits.max - highest,
            max_vel: limits.max_vel * fraction,
            max_acc: limits.max_acc * fraction,
            max_jerk: limits.max_jerk * fraction,
        })
    }

    /// Returns the pose with the offsets.
    pub(crate) fn whole_pose(&self) -> Pose {
        let mut pose = self.pose;
        for (place, axis) in pose.iter_mut().zip(&self.axes) {
            *place += axis.offset.tp.pos;
        }
        pose
    }

    /// Returns whether any offset is applied, and whether a limit keeps one from its request.
    pub(crate) fn is_offset(&self) -> (bool, bool) {
        self.axes.iter().fold((false, false), |(is_there, is_limited), axis| {
            let offset = &axis.offset;
            (is_there | offset.is_there(), is_limited | offset.is_limited())
        })
    }

    /// Computes the fraction of each joint's velocity and acceleration that corrections and offsets leave to moves.
    pub(crate) fn update_planning_fractions(&mut self) {
        let mut planning_fractions = [1.0; MAX_JOINTS];
        for (fraction, joint) in planning_fractions.iter_mut().zip(&self.joints) {
            *fraction -= joint.config.correction_share();
        }
        let identity = self.kinematics.kind() == KinematicsKind::Identity;
        for (n, axis) in
            self.axes.iter().enumerate().filter(|(_, a)| a.config.offset_fraction > 0.0)
        {
            let (mut here, mut there) = (self.places(), self.places());
            let mut beside = self.pose;
            if let Some(place) = beside.get_mut(n) {
                *place += 1.0;
            }
            let known = identity
                && self.kinematics.inverse(&self.pose, &mut here).is_ok()
                && self.kinematics.inverse(&beside, &mut there).is_ok();
            for (fraction, (here, there)) in
                planning_fractions.iter_mut().zip(here.iter().zip(&there))
            {
                if !known || fabs(there - here) > 0.5 {
                    *fraction *= 1.0 - axis.config.offset_fraction;
                }
            }
        }
        self.planning_fractions = planning_fractions;
    }

    /// Refuses commands that cannot be combined with an offset.
    pub(crate) fn needs_no_offset(&self) -> Result<(), Refusal> {
        if self.is_offset().0 {
            return Err(Refusal::new("joints cannot be moved while an external offset is applied"));
        }
        Ok(())
    }
}

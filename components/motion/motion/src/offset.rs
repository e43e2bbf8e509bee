//! Realtime. External offsets, added by pins to the position of an axis within a share of its limits.

use crate::{
    commands::command::Mode, commands::refusal::Refusal, jogger::Room, path::planner::SimpleTp,
    pins::Pins, setup::MAX_JOINTS, state::State,
};
use hal_component::{In, KinematicsKind, Out, Pose};
use libm::fabs;

/// External offset of one axis.
#[derive(Debug, Default)]
pub(crate) struct Offset {
    pub(crate) tp: SimpleTp,
    /// Requested offset, regardless of limits.
    request: f64,
    /// Offset of the previous cycle.
    last: f64,
    counts: Option<i32>,
    /// True if a limit keeps the offset from its request.
    is_limited: bool,
}

/// Pins of an external offset.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OffsetPins {
    pub(crate) enable: In<bool>,
    pub(crate) clear: In<bool>,
    pub(crate) counts: In<i32>,
    pub(crate) scale: In<f64>,
    pub(crate) request: Out<f64>,
    pub(crate) now: Out<f64>,
}

impl Offset {
    /// Reads the pins.
    fn ask(&mut self, pins: &OffsetPins, allowed: bool) {
        let counts = pins.counts.get();
        let old = self.counts.replace(counts).unwrap_or(counts);
        if pins.clear.get() {
            self.request = 0.0;
        } else if allowed && pins.enable.get() {
            let more = f64::from(counts.wrapping_sub(old)) * pins.scale.get();
            if (self.request + more).is_finite() {
                self.request += more;
            }
        }
    }

    /// Moves the offset one cycle towards its request, as far as the limits permit.
    fn step(&mut self, room: &Room, dt: f64) {
        self.last = self.tp.pos;
        let mut target = self.request;
        // Crossed limits are both ignored.
        if target > room.max && room.max >= room.min {
            target = room.max;
        } else if target < room.min && room.max >= room.min {
            target = room.min;
        }
        self.is_limited = target != self.request;
        self.tp.target = target;
        self.tp.max_vel = room.max_vel;
        self.tp.max_acc = room.max_acc;
        self.tp.enable = true;
        self.tp.step_exactly(dt);
    }

    /// Reduces the motion of this cycle to a part.
    pub(crate) fn slow_down(&mut self, factor: f64) {
        self.tp.slow_down(self.last, factor);
    }

    /// Stops the offset where it was in the previous cycle.
    pub(crate) fn stay(&mut self) {
        self.be_at(self.last);
    }

    /// Sets the offset and its request to a value, at rest.
    fn be_at(&mut self, place: f64) {
        *self = Self { request: place, last: place, counts: self.counts, ..Self::default() };
        self.tp.reset(place);
    }

    /// Returns whether the offset moved in this cycle.
    pub(crate) fn moves(&self) -> bool {
        self.tp.pos.to_bits() != self.last.to_bits()
    }

    fn is_there(&self) -> bool {
        self.tp.pos != 0.0 || self.tp.vel != 0.0
    }

    /// Writes the pins.
    pub(crate) fn show(&self, pins: &OffsetPins) {
        pins.request.set(self.request);
        pins.now.set(self.tp.pos);
    }
}

impl State {
    /// Reads the requests from the pins, and moves the offsets.
    pub(crate) fn offsets(&mut self, pins: &Pins, dt: f64) {
        let in_axes = self.enabled && self.mode != Mode::Free;
        let allowed = in_axes && self.is_all_homed();
        for n in 0..self.axes.len() {
            let Some(pins) = pins.axes.get(n).map(crate::axis::offset) else { continue };
            let Some(axis) = self.axes.get_mut(n) else { continue };
            axis.offset.ask(&pins, allowed && axis.config.offset_share > 0.0);
            let room = if in_axes { self.offset_room(n) } else { None };
            let Some(axis) = self.axes.get_mut(n) else { continue };
            match room {
                Some(room) => axis.offset.step(&room, dt),
                // An applied offset does not vanish at once while the machine is on.
                None if in_axes => axis.offset.be_at(axis.offset.tp.pos),
                None => axis.offset.be_at(0.0),
            }
        }
    }

    /// Returns the limits of an offset: its travel, and its share of the axis's velocity and acceleration.
    fn offset_room(&self, n: usize) -> Option<Room> {
        let axis = self.axes.get(n)?;
        let share = axis.config.offset_share;
        if share <= 0.0 {
            return None;
        }
        // At rest and without a request, nothing is computed.
        if axis.offset.request == 0.0 && !axis.offset.is_there() {
            return Some(Room::default());
        }
        let at = *self.pose.get(n)?;
        let room = self.axis_room(n).ok()?;
        Some(Room {
            min: room.min - at,
            max: room.max - at,
            max_vel: room.max_vel * share,
            max_acc: room.max_acc * share,
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
        let any = |is: fn(&Offset) -> bool| self.axes.iter().any(|a| is(&a.offset));
        (any(Offset::is_there), any(|o| o.is_limited))
    }

    /// Computes the share of each joint's velocity and acceleration that the offsets leave to moves.
    pub(crate) fn share(&mut self) {
        let mut shares = [1.0; MAX_JOINTS];
        let identity = self.kinematics.kind() == KinematicsKind::Identity;
        for (n, axis) in self.axes.iter().enumerate().filter(|(_, a)| a.config.offset_share > 0.0) {
            let (mut here, mut there) = (self.places(), self.places());
            let mut beside = self.pose;
            if let Some(place) = beside.get_mut(n) {
                *place += 1.0;
            }
            let known = identity
                && self.kinematics.inverse(&self.pose, &mut here).is_ok()
                && self.kinematics.inverse(&beside, &mut there).is_ok();
            for (share, (here, there)) in shares.iter_mut().zip(here.iter().zip(&there)) {
                if !known || fabs(there - here) > 0.5 {
                    *share *= 1.0 - axis.config.offset_share;
                }
            }
        }
        self.shares = shares;
    }

    /// Refuses commands that cannot be combined with an offset.
    pub(crate) fn needs_no_offset(&self) -> Result<(), Refusal> {
        if self.is_offset().0 {
            return Err(Refusal::new("joints cannot be moved while an external offset is applied"));
        }
        Ok(())
    }
}

//! Realtime. External offsets: what pins add to the position of an axis, within a share of its limits.

use crate::{
    command::Mode, jogger::Room, pins::Pins, planner::SimpleTp, refusal::Refusal,
    setup::MAX_JOINTS, state::State,
};
use hal_component::{In, KinematicsKind, Out, Pose};
use libm::fabs;

/// The offset of one axis.
#[derive(Debug, Default)]
pub(crate) struct Offset {
    pub(crate) tp: SimpleTp,
    /// Where it shall be, wherever the limits are.
    request: f64,
    /// Where it was a cycle before.
    last: f64,
    counts: Option<i32>,
    /// A limit keeps it from its request.
    is_limited: bool,
}

/// The pins that ask for it.
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

    /// One cycle on the way to where it shall be, or as far as there is room for.
    fn step(&mut self, room: &Room, dt: f64) {
        self.last = self.tp.pos;
        let mut target = self.request;
        // Of crossed limits none is kept to.
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

    /// It goes only a part of its way in this cycle.
    pub(crate) fn slow_down(&mut self, factor: f64) {
        self.tp.slow_down(self.last, factor);
    }

    /// It cannot go on: it stays where it was a cycle before.
    pub(crate) fn stay(&mut self) {
        self.be_at(self.last);
    }

    /// It stands still there, and that is what was asked for.
    fn be_at(&mut self, place: f64) {
        *self = Self { request: place, last: place, counts: self.counts, ..Self::default() };
        self.tp.reset(place);
    }

    /// It went on in this cycle.
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
    /// Reads what the pins ask for, and moves the offsets.
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
                // What is applied does not go away at once while the machine is on.
                None if in_axes => axis.offset.be_at(axis.offset.tp.pos),
                None => axis.offset.be_at(0.0),
            }
        }
    }

    /// Between which an offset may be, and how fast it goes: its share of what the axis may do.
    fn offset_room(&self, n: usize) -> Option<Room> {
        let axis = self.axes.get(n)?;
        let share = axis.config.offset_share;
        if share <= 0.0 {
            return None;
        }
        // Where it stands still, nothing is computed.
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

    /// The pose with the offsets.
    pub(crate) fn whole_pose(&self) -> Pose {
        let mut pose = self.pose;
        for (place, axis) in pose.iter_mut().zip(&self.axes) {
            *place += axis.offset.tp.pos;
        }
        pose
    }

    /// Whether any is applied; and whether a limit keeps one from its request.
    pub(crate) fn is_offset(&self) -> (bool, bool) {
        let any = |is: fn(&Offset) -> bool| self.axes.iter().any(|a| is(&a.offset));
        (any(Offset::is_there), any(|o| o.is_limited))
    }

    /// Finds what the offsets leave to the moves of each joint, of its velocity and acceleration.
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

    /// Refuses what cannot be with an offset.
    pub(crate) fn needs_no_offset(&self) -> Result<(), Refusal> {
        if self.is_offset().0 {
            return Err(Refusal::new("joints cannot be moved while an external offset is applied"));
        }
        Ok(())
    }
}

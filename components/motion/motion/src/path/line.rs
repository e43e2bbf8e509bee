//! Realtime. One straight move: the speed that its joints permit, and positions along it.

use crate::{axis::Axis, commands::refusal::Refusal, joint::Joint, setup::MAX_JOINTS};
use hal_component::{KinematicsKind, KinematicsRef, Pose, Unsolved};
use libm::{fabs, sqrt};

/// Number of parts into which a path is divided to sample the motion of its joints.
const PARTS: u32 = 32;

/// Positions of all joints.
pub(crate) type Places = [f64; MAX_JOINTS];

/// Requested and permitted feed of a move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveRequest {
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    /// Velocity limit that no override may exceed.
    pub(crate) max_velocity: f64,
}

/// Joints, axes and kinematics that a move uses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Machine<'m> {
    pub(crate) kinematics: &'m KinematicsRef,
    pub(crate) joints: &'m [Joint],
    pub(crate) axes: &'m [Axis],
    /// Fraction of velocity and acceleration that each joint has for moves.
    pub(crate) planning_fractions: &'m [f64; MAX_JOINTS],
}

/// A move with its limits: velocity and acceleration are along its length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) start: Pose,
    pub(crate) end: Pose,
    pub(crate) length: f64,
    pub(crate) velocity: f64,
    pub(crate) max_velocity: f64,
    pub(crate) acceleration: f64,
}

impl Line {
    /// Plans a move. Refuses it if its end, or with non-trivial kinematics any part of the path, is beyond a limit, or
    /// if a joint was never configured.
    pub(crate) fn plan(
        start: Pose,
        end: Pose,
        request: MoveRequest,
        machine: Machine<'_>,
    ) -> Result<Self, Refusal> {
        let mut line = Self {
            start,
            end,
            length: length(&start, &end),
            velocity: request.velocity,
            max_velocity: request.max_velocity,
            acceleration: request.acceleration,
        };
        for (n, (axis, end)) in machine.axes.iter().zip(&end).enumerate() {
            axis.check(n, *end)?;
        }
        let moves = line.moves(machine)?;
        if !(line.length > 0.0 && line.length.is_finite() && moves.iter().any(|m| m.slope > 0.0)) {
            line.length = 0.0;
            return Ok(line);
        }
        line.limit_by_axes(machine.axes);
        line.limit_by_joints(machine, &moves);
        if line.velocity > line.max_velocity {
            line.velocity = line.max_velocity;
        }
        Ok(line)
    }

    fn limit_by_axes(&mut self, axes: &[Axis]) {
        for ((axis, start), end) in axes.iter().zip(&self.start).zip(&self.end) {
            let slope = fabs(end - start) / self.length;
            if slope > 0.0 {
                let (c, fraction) = (&axis.config, 1.0 - axis.config.offset_fraction);
                self.max_velocity = less(self.max_velocity, c.max_velocity * fraction / slope);
                self.acceleration = less(self.acceleration, c.max_acceleration * fraction / slope);
            }
        }
    }

    fn limit_by_joints(&mut self, machine: Machine<'_>, moves: &[Move]) {
        let of = |(joint, fraction): (&Joint, &f64)| {
            (joint.config.max_velocity * fraction, joint.config.max_acceleration * fraction)
        };
        let limits = || machine.joints.iter().zip(machine.planning_fractions).map(of);
        let moving = || limits().zip(moves).filter(|(_, m)| m.slope > 0.0);
        for ((velocity, acceleration), m) in moving() {
            self.max_velocity = less(self.max_velocity, velocity / m.slope);
            if m.curve > 0.0 {
                // Half of the acceleration is for the curve, half for the change of speed.
                let cornering = sqrt(0.5 * acceleration / m.curve);
                self.max_velocity = less(self.max_velocity, cornering);
            }
        }
        let fastest = self.max_velocity;
        for ((_, acceleration), m) in moving() {
            let rest = acceleration - m.curve * fastest * fastest;
            self.acceleration = less(self.acceleration, rest / m.slope);
        }
    }

    /// Returns the velocity with an override, clamped to the limit.
    pub(crate) fn scaled(&self, scale: f64) -> f64 {
        less(self.velocity * scale, self.max_velocity)
    }

    /// Returns the pose at a distance along the move.
    pub(crate) fn at(&self, distance: f64) -> Pose {
        if distance >= self.length {
            return self.end;
        }
        let fraction = distance / self.length;
        let mut pose = self.start;
        for (p, end) in pose.iter_mut().zip(&self.end) {
            *p += (end - *p) * fraction;
        }
        pose
    }

    /// Returns the motion of the joints along the move.
    fn moves(&self, machine: Machine<'_>) -> Result<[Move; MAX_JOINTS], Refusal> {
        let Machine { kinematics, joints, .. } = machine;
        let parts = if kinematics.kind() == KinematicsKind::Identity { 1 } else { PARTS };
        let step = self.length / f64::from(parts);
        let mut moves = [Move::default(); MAX_JOINTS];
        let mut places: Places = [0.0; MAX_JOINTS];
        for (place, joint) in places.iter_mut().zip(joints) {
            *place = joint.pos_cmd;
        }
        for part in 0..=parts {
            let last = places;
            let at = if part == parts { self.end } else { self.at(f64::from(part) * step) };
            kinematics.inverse(&at, &mut places).map_err(no_way)?;
            if places.iter().any(|p| !p.is_finite()) {
                return Err(no_way(Unsolved::Unreachable));
            }
            for ((m, place), old) in moves.iter_mut().zip(&places).zip(&last) {
                m.add(part, place - old, step);
            }
            for (n, (joint, (m, place))) in
                joints.iter().zip(moves.iter_mut().zip(&places)).enumerate()
            {
                if part == 0 {
                    m.starts_beyond = joint.is_beyond(*place);
                } else if part == parts || !m.starts_beyond {
                    check(n, joint, *place)?;
                }
                if m.slope > 0.0 && !joint.active {
                    return Err(Refusal::joint(
                        "linear move needs a joint that is not configured",
                        "linear move needs joint {}, which is not configured",
                        n,
                    ));
                }
            }
        }
        Ok(moves)
    }
}

/// Returns the refusal for a path on which the kinematics have no solution.
const fn no_way(why: Unsolved) -> Refusal {
    Refusal::new(match why {
        Unsolved::Unreachable | Unsolved::NoNumber => "linear move: the kinematics cannot go there",
        Unsolved::Geometry => "linear move: the lengths of the machine make no sense",
        Unsolved::Limits => "linear move: a joint of the arm cannot go that far",
        Unsolved::Undetermined => "linear move: it passes a singular place",
        Unsolved::NotFound => "linear move: the kinematics found no answer in time",
    })
}

/// Bounds of one joint's motion along a path.
#[derive(Clone, Copy, Debug, Default)]
struct Move {
    last_way: f64,
    last_bend: f64,
    /// Maximum displacement per unit of path.
    slope: f64,
    /// Maximum change of `slope` per unit of path.
    curve: f64,
    starts_beyond: bool,
}

impl Move {
    /// Adds one sample's joint displacement. Between samples, slope and curvature are bounded by the second and third
    /// finite differences.
    fn add(&mut self, part: u32, way: f64, step: f64) {
        if part == 0 || step <= 0.0 {
            return;
        }
        let bend = if part > 1 { flat(way - self.last_way) } else { 0.0 };
        let twist = if part > 2 { fabs(flat(bend - self.last_bend)) } else { 0.0 };
        let slope = (fabs(way) + 0.5 * fabs(bend) + 0.25 * twist) / step;
        let curve = (fabs(bend) + 0.5 * twist) / (step * step);
        (self.last_way, self.last_bend) = (way, bend);
        if slope > self.slope {
            self.slope = slope;
        }
        if curve > self.curve {
            self.curve = curve;
        }
    }
}

/// Returns a difference with rounding errors set to zero.
fn flat(difference: f64) -> f64 {
    if fabs(difference) > ROUNDING { difference } else { 0.0 }
}

/// Changes below this are rounding errors.
const ROUNDING: f64 = 1e-11;

fn check(n: usize, joint: &Joint, place: f64) -> Result<(), Refusal> {
    if joint.extra || !joint.is_beyond(place) {
        return Ok(());
    }
    Err(if place > joint.config.max_limit {
        Refusal::joint(
            "linear move would exceed a joint's positive limit",
            "linear move would exceed joint {}'s positive limit",
            n,
        )
    } else {
        Refusal::joint(
            "linear move would exceed a joint's negative limit",
            "linear move would exceed joint {}'s negative limit",
            n,
        )
    })
}

fn less(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// Returns the length that determines the feed: of x y z; if they do not move, of u v w; else of a b c.
fn length(start: &Pose, end: &Pose) -> f64 {
    let part = |from: usize| {
        let ways = start.iter().zip(end).skip(from).take(3);
        sqrt(ways.map(|(s, e)| (e - s) * (e - s)).sum())
    };
    let [linear, rotary, extra] = [part(0), part(3), part(6)];
    if linear > 0.0 {
        linear
    } else if extra > 0.0 {
        extra
    } else {
        rotary
    }
}

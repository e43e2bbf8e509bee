//! The certificate: a check of every cell before the follower may see it.
//!
//! The check repeats no step of the plan. It bounds the derivatives of a polynomial by its extrema instead of its hull,
//! tests the three conditions of the limits instead of solving them, and compares each cell with every neighbour in
//! reach instead of sweeping. A cell that fails gets the limits that the check itself found, and counts as a rejection.

use std::collections::VecDeque;

use crate::{
    bounds::Bounds,
    curve::Curve,
    erosion::Raw,
    pose::{Group, Pose},
    speed::{JointBounds, Law},
};

/// Reason for which a cell was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Velocity, acceleration or jerk of an axis or joint would exceed its limit in the cell.
    Limits,
    /// The limits of a neighbour in reach of the jerk filter are lower than those of the cell.
    Neighbour,
}

/// A rejected cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rejection {
    /// Reason.
    pub rule: Rule,
    /// Line of the program.
    pub line: u32,
    /// Speed that was proposed, in units of the path coordinate per second.
    pub speed: f64,
}

/// The check of one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Certificate {
    raws: VecDeque<Raw>,
    pub(crate) rejections: u64,
    pub(crate) last: Option<Rejection>,
}

impl Certificate {
    /// Checks the limits of a cell before erosion, and reduces them until they hold.
    pub(crate) fn judge(
        &mut self,
        law: &Law,
        curve: &Curve,
        lead: Group,
        joints: Option<&JointBounds>,
        raw: &mut Raw,
    ) {
        let bounds = exact(curve, raw.from, raw.from + raw.length, lead);
        for round in 0..64 {
            let a = &raw.allowed;
            let top = a.rest - a.fade * a.speed * a.speed;
            // Between rest and top speed the sum of both shares is linear in v², so the ends suffice.
            if law.holds(&bounds, joints, a.speed, top)
                && (a.fade == 0.0 || law.holds(&bounds, joints, 0.0, a.rest))
            {
                return;
            }
            if round == 0 {
                self.reject(Rule::Limits, raw);
            }
            raw.allowed.speed *= 0.5;
            raw.allowed.rest *= 0.5;
            raw.allowed.fade = 0.0;
        }
    }

    /// Remembers a cell of the run, so that its neighbours can be compared with it.
    pub(crate) fn remember(&mut self, raw: &Raw) {
        self.raws.push_back(*raw);
    }

    /// Compares an eroded cell with the limits of every cell in reach. `time` is the reach in seconds, `longest` the
    /// longest reach as a length.
    pub(crate) fn admit(&mut self, cell: &mut Raw, time: f64, longest: f64) {
        while self.raws.front().is_some_and(|r| r.end() < cell.start - longest - 1.0) {
            self.raws.pop_front();
        }
        let (mut speed, mut rest) = (cell.allowed.speed, cell.allowed.rest);
        for raw in &self.raws {
            if raw.start > cell.end() + longest {
                break;
            }
            let distance = (raw.start - cell.end()).max(cell.start - raw.end());
            if distance < raw.allowed.speed * time {
                speed = speed.min(raw.allowed.speed);
                rest = rest.min(raw.allowed.rest);
            }
        }
        if speed < cell.allowed.speed || rest < cell.allowed.rest {
            self.reject(Rule::Neighbour, cell);
            cell.allowed.speed = speed;
            cell.allowed.rest = rest;
        }
    }

    /// Forgets the run.
    pub(crate) fn restart(&mut self) {
        self.raws.clear();
    }

    fn reject(&mut self, rule: Rule, raw: &Raw) {
        self.rejections = self.rejections.saturating_add(1);
        self.last = Some(Rejection { rule, line: raw.line, speed: raw.allowed.speed });
    }
}

/// Bounds of the derivatives: extrema of the second and third, and a subdivided hull of the first.
fn exact(curve: &Curve, from: f64, to: f64, lead: Group) -> Bounds {
    let Curve::Poly { c, length } = curve else {
        return curve.bounds(from, to, lead);
    };
    let middle = 0.5 * (from + to);
    let (a, b) = (curve.bounds(from, middle, lead), curve.bounds(middle, to, lead));
    let (u0, u1) = (from / length, to / length);
    let (k2, k3) = (1.0 / (length * length), 1.0 / (length * length * length));
    let (mut second, mut third) = (Pose::ZERO, Pose::ZERO);
    let [_, _, c2, c3, c4, c5] = *c;
    let rows = c2.0.iter().zip(&c3.0).zip(&c4.0).zip(&c5.0);
    let slots = second.0.iter_mut().zip(third.0.iter_mut());
    for ((second, third), (((c2, c3), c4), c5)) in slots.zip(rows) {
        let bend = |u: f64| (((20.0 * c5 * u + 12.0 * c4) * u + 6.0 * c3) * u + 2.0 * c2).abs();
        let (p, q, r) = (60.0 * c5, 24.0 * c4, 6.0 * c3);
        let twist = |u: f64| ((p * u + q) * u + r).abs();
        let inside = |u: f64| u0 < u && u < u1;
        let mut high = bend(u0).max(bend(u1));
        let mut steep = twist(u0).max(twist(u1));
        let top = -q / (2.0 * p);
        if inside(top) {
            steep = steep.max(twist(top));
        }
        let root = q * q - 4.0 * p * r;
        if root >= 0.0 {
            let w = -0.5 * (q + root.sqrt().copysign(q));
            for u in [w / p, r / w] {
                if inside(u) {
                    high = high.max(bend(u));
                }
            }
        }
        *second = high * k2;
        *third = steep * k3;
    }
    Bounds { first: a.first.max(&b.first), second, third, speed: a.speed.max(b.speed) }
}

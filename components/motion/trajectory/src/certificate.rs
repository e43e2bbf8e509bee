//! The certificate: a check of every cell before the follower may see it.
//!
//! The check uses other means than the plan. It bounds the derivatives of a polynomial by its extrema instead of its hull,
//! tests the three conditions of the limits instead of solving them, compares each cell with every neighbour in
//! reach instead of sweeping, and bounds the deviation of joined lines, and of blends between lines, by the distance of
//! their hull from the lines. Only blends beside arcs and polynomials are bounded as in the plan, on shorter pieces. A
//! cell that fails gets the limits that the check itself found, and counts as a rejection; a blend that fails becomes a
//! stop, and lines whose spline fails stay lines.

use core::fmt;
use std::collections::VecDeque;

use crate::{
    blend::{Blend, deviation_again},
    bounds::{Bounds, poly_slope},
    curve::Curve,
    erosion::Raw,
    pose::Pose,
    segment::{Segment, Tolerances},
    speed::{Allowed, JointBounds, Law},
};

mod joined;
#[cfg(test)]
mod tests;

pub(crate) use joined::Joined;

/// Reason for which a cell was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Velocity, acceleration or jerk of an axis or joint would exceed its limit in the cell.
    Limits,
    /// The limits of a neighbour in reach of the jerk filter are lower than those of the cell.
    Neighbour,
    /// A blend would leave its tolerance; the joint becomes a stop.
    Deviation,
    /// A spline of joined lines would leave its tolerance; the lines stay as they are.
    Joining,
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

impl fmt::Display for Rejection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rule, line, speed } = self;
        match rule {
            Rule::Limits => write!(
                f,
                "line {line}: a limit of an axis or joint would be exceeded at a speed of {speed}; the motion is slower \
                 there"
            ),
            Rule::Neighbour => write!(
                f,
                "line {line}: the speed of {speed} is too high for a slower part nearby; the motion is slower there"
            ),
            Rule::Deviation => {
                write!(
                    f,
                    "line {line}: the blend after it would leave the tolerance; the motion stops there"
                )
            }
            Rule::Joining => {
                write!(
                    f,
                    "line {line}: the lines from it on would leave the tolerance as a curve; they stay lines"
                )
            }
        }
    }
}

/// Limits and the interval of the run in which they act.
#[derive(Clone, Copy, Debug)]
struct Acting {
    from: f64,
    to: f64,
    allowed: Allowed,
    /// Acceleration at full speed.
    top: f64,
}

/// Neighbouring cells, and the lowest limits and the widest interval of them all.
#[derive(Clone, Debug)]
struct Block {
    cells: Vec<Acting>,
    from: f64,
    to: f64,
    speed: f64,
    rest: f64,
    top: f64,
}

impl Block {
    const CELLS: usize = 16;

    fn clear(&mut self) {
        self.cells.clear();
        *self = Self { cells: core::mem::take(&mut self.cells), ..Self::default() };
    }

    fn add(&mut self, acts: &Acting) {
        let Allowed { speed, rest, .. } = acts.allowed;
        self.from = self.from.min(acts.from);
        self.to = self.to.max(acts.to);
        self.speed = self.speed.min(speed);
        self.rest = self.rest.min(rest);
        self.top = self.top.min(acts.top);
        self.cells.push(*acts);
    }
}

impl Default for Block {
    fn default() -> Self {
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        Self { cells: Vec::new(), from: high, to: low, speed: high, rest: high, top: high }
    }
}

/// The check of one run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Certificate {
    blocks: VecDeque<Block>,
    /// A block that is over, with its memory.
    spare: Option<Block>,
    pub(crate) rejections: u64,
    pub(crate) last: Option<Rejection>,
}

impl Certificate {
    /// Checks the limits of a cell before erosion, and reduces them until they hold.
    pub(crate) fn judge(
        &mut self,
        law: &Law,
        curve: &Curve,
        joints: Option<&JointBounds>,
        raw: &mut Raw,
    ) {
        let bounds = exact(curve, raw.from, raw.from + raw.length);
        for round in 0..64 {
            if law.holds(&bounds, joints, &raw.allowed) {
                return;
            }
            if round == 0 {
                self.reject(Rule::Limits, raw);
            }
            let speed = 0.5 * raw.allowed.speed;
            let rest = 0.5 * raw.allowed.at(speed);
            raw.allowed = Allowed { speed, rest, fade: 0.0 };
        }
    }

    /// Checks the deviation of a blend. Returns false if it must not be used.
    pub(crate) fn allows(
        &mut self,
        blend: &Blend,
        a: &Segment,
        b: &Segment,
        t: &Tolerances,
    ) -> bool {
        let good = deviation_again(blend, a, b, t) <= 1.0 + 1e-9;
        if !good {
            self.refuse(Rule::Deviation, a.line, 0.0);
        }
        good
    }

    /// Checks the deviation of joined lines. Returns false if they must stay lines.
    pub(crate) fn allows_joining(&mut self, joined: &Joined<'_>) -> bool {
        let good = joined.is_inside();
        if !good {
            self.refuse(Rule::Joining, joined.lines.first().map_or(0, |l| l.line), 0.0);
        }
        good
    }

    /// Remembers a cell of the run, so that its neighbours can be compared with it. `time` is the reach in seconds.
    pub(crate) fn remember(&mut self, raw: &Raw, time: f64) {
        let allowed = raw.allowed;
        let reach = allowed.speed * time;
        let (from, to) = (raw.start - reach, raw.end() + reach);
        let acts = Acting { from, to, allowed, top: allowed.top() };
        match self.blocks.back_mut() {
            Some(block) if block.cells.len() < Block::CELLS => block.add(&acts),
            _ => {
                // A block that is over gives its memory to the new one.
                let mut block = self.spare.take().unwrap_or_default();
                block.clear();
                block.add(&acts);
                self.blocks.push_back(block);
            }
        }
    }

    /// Compares an eroded cell with the limits of every cell in reach. Cells come in the order of the run.
    pub(crate) fn admit(&mut self, cell: &mut Raw) {
        let (from, to) = (cell.start, cell.end());
        while self.blocks.front().is_some_and(|b| b.to <= from) {
            self.spare = self.blocks.pop_front();
        }
        let Allowed { mut speed, mut rest, .. } = cell.allowed;
        let full = cell.allowed.top();
        let mut top = full;
        let mut good = true;
        for b in &self.blocks {
            // A block that as a whole is higher, or out of reach, needs no look at its cells.
            if b.to <= from
                || to <= b.from
                || cell.allowed.speed <= b.speed && cell.allowed.rest <= b.rest && full <= b.top
            {
                continue;
            }
            for acts in &b.cells {
                let low = acts.allowed;
                let below = cell.allowed.speed <= low.speed && cell.allowed.rest <= low.rest;
                if acts.to <= from || to <= acts.from || below && full <= acts.top {
                    continue;
                }
                // Both accelerations are linear in v², so rest and full speed suffice.
                good &= below && full <= low.at(cell.allowed.speed) + 1e-12 * low.rest;
                speed = speed.min(low.speed);
                rest = rest.min(low.rest);
                top = top.min(acts.top);
            }
        }
        if !good {
            self.reject(Rule::Neighbour, cell);
            cell.allowed = Allowed::between(speed, rest, top);
        }
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn memory(&self) -> usize {
        let block = size_of::<Block>() + Block::CELLS * size_of::<Acting>();
        self.blocks.capacity() * block
    }

    /// Forgets the run.
    pub(crate) fn restart(&mut self) {
        self.blocks.clear();
    }

    fn reject(&mut self, rule: Rule, raw: &Raw) {
        self.refuse(rule, raw.line, raw.allowed.speed);
    }

    const fn refuse(&mut self, rule: Rule, line: u32, speed: f64) {
        self.rejections = self.rejections.saturating_add(1);
        self.last = Some(Rejection { rule, line, speed });
    }
}

/// Bounds of the derivatives of a polynomial: extrema of the second and third, and a subdivided hull of the first. Bounds
/// of an arc: the values at both ends, and the radius where a derivative changes its sign between them.
fn exact(curve: &Curve, from: f64, to: f64) -> Bounds {
    let (c, length) = match curve {
        Curve::Line { slope, .. } => return Bounds { first: slope.abs(), ..Bounds::default() },
        Curve::Arc { arm, side, rate, drift, .. } => {
            let mut out = arc(arm, side, *rate, from, to);
            out.first = out.first + drift.abs();
            return out;
        }
        Curve::Poly { c, length } => (c, length),
    };
    let (u0, u1) = (from / length, to / length);
    let (k2, k3) = (1.0 / (length * length), 1.0 / (length * length * length));
    let (mut second, mut third) = (Pose::ZERO, Pose::ZERO);
    let [_, _, c2, c3, c4, c5] = *c;
    let rows = c2.0.iter().zip(&c3.0).zip(&c4.0).zip(&c5.0);
    let slots = second.0.iter_mut().zip(third.0.iter_mut());
    for ((second, third), (((c2, c3), c4), c5)) in slots.zip(rows) {
        if *c2 == 0.0 && *c3 == 0.0 && *c4 == 0.0 && *c5 == 0.0 {
            continue;
        }
        let bend = |u: f64| (((20.0 * c5 * u + 12.0 * c4) * u + 6.0 * c3) * u + 2.0 * c2).abs();
        let (p, q, r) = (60.0 * c5, 24.0 * c4, 6.0 * c3);
        let twist = |u: f64| ((p * u + q) * u + r).abs();
        let inside = |u: f64| u0 < u && u < u1;
        let mut high = bend(u0).max(bend(u1));
        let mut steep = twist(u0).max(twist(u1));
        if p != 0.0 {
            let top = -q / (2.0 * p);
            if inside(top) {
                steep = steep.max(twist(top));
            }
        }
        // Without both, the second derivative is linear.
        let root = if p != 0.0 || q != 0.0 { q * q - 4.0 * p * r } else { -1.0 };
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
    Bounds { first: poly_slope(c, *length, u0, u1), second, third, speed: 0.0 }
}

/// Bounds of the derivatives of a circle.
fn arc(arm: &[f64; 3], side: &[f64; 3], rate: f64, from: f64, to: f64) -> Bounds {
    let mut out = Bounds::default();
    let ((s0, c0), (s1, c1)) = (libm::sincos(rate * from), libm::sincos(rate * to));
    let wide = (rate * (to - from)).abs() >= core::f64::consts::PI;
    let k = rate.abs();
    let rows = out.first.0.iter_mut().zip(&mut out.second.0).zip(&mut out.third.0);
    for (((first, second), third), (a, b)) in rows.zip(arm.iter().zip(side)) {
        let (r0, r1) = (a * c0 + b * s0, a * c1 + b * s1);
        let (t0, t1) = (b * c0 - a * s0, b * c1 - a * s1);
        let radius = (a * a + b * b).sqrt();
        let peak = |x0: f64, x1: f64, slope0: f64, slope1: f64| {
            let turns = wide || slope0 * slope1 <= 0.0;
            if turns { radius } else { x0.abs().max(x1.abs()) }
        };
        *first = k * peak(t0, t1, r0, r1);
        *second = k * k * peak(r0, r1, t0, t1);
        *third = k * *first * k;
    }
    out
}

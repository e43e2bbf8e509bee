//! Realtime. The limits of a period: those of the cell, and of what is ahead and behind.

use super::{AHEAD, BESIDE, Pursuer};
use crate::{
    chaser::{Aim, Chaser, Rates},
    curve::Curve,
    machine::Limits,
    track::{Cell, Path},
};
use libm::fabs;

/// Part of the limits of jerk in use, so that rounding is no violation.
const SHARE: f64 = 1.0 - 1e-5;

/// Parts of acceleration and jerk in use along curves, whose limits are those of continuous motion and not of periods.
const CURVED: [f64; 2] = [0.85, 0.75];

/// Part of the speed of a cell in use beside curves, and with which a slower cell is entered.
const SLOWER: f64 = 0.99;

/// Part of the acceleration at rest that is left at any speed, so that a motion can always brake.
const LEAST: f64 = 0.02;

impl Pursuer {
    /// Returns the limits of this period. Those of the curves ahead, and of one behind as far as the plan's own limits reach, count from
    /// the moment in which the motion is calm enough for them.
    pub(super) fn limits_here(&mut self, track: &impl Path, cell: &Cell) -> Limits {
        let velocity = self.now.velocity;
        let own = self.limits_of(track, cell, velocity);
        let mut is_near = self.is_curved(track, cell);
        self.since_curve = if is_near { 0 } else { self.since_curve.saturating_add(1) };
        is_near |= self.since_curve <= u32::from(cell.samples) + BESIDE;
        let mut low = self.limits_of_curve(cell, velocity);
        let (mut last, mut number, mut way) = (*cell, self.cell, self.to_go);
        let mut can_brake = true;
        for _ in 0..AHEAD {
            number += 1;
            let Some(next) = track.cell(number).filter(|_| !last.stop) else { break };
            is_near |= self.is_curved(track, &next);
            low = lower(low, self.limits_of_curve(&next, velocity));
            if next.speed < fabs(velocity) && !self.is_low {
                let chaser = Chaser { limits: low, period: self.period };
                can_brake &= chaser.allows(self.now, 0.0, self.early(way), SLOWER * next.speed);
            }
            way += next.length;
            last = next;
        }
        let low = Limits { velocity: own.velocity * SLOWER, ..low };
        let a = fabs(self.now.acceleration);
        let is_calm = can_brake
            && a <= low.acceleration
            && a * a <= 2.0 * low.jerk * (low.velocity - fabs(velocity));
        self.is_low = is_near && (self.is_low || is_calm);
        if self.is_low { low } else { own }
    }

    fn is_curved(&self, track: &impl Path, cell: &Cell) -> bool {
        !self.jerk_of(track, cell.curve).0
    }

    /// Returns the highest acceleration that the rest of the track allows to a motion that wants this one. With `is_back` it is
    /// that of a motion that goes back, and both are those backwards.
    pub(super) fn highest(
        &self,
        track: &impl Path,
        cell: &Cell,
        mut limits: Limits,
        wanted: f64,
        is_back: bool,
    ) -> f64 {
        let Rates { velocity, acceleration } = self.now;
        let (now, mut distance) = match is_back {
            true => {
                let back = Rates { velocity: -velocity, acceleration: -acceleration };
                (back, cell.length - self.to_go)
            }
            false => (self.now, self.to_go),
        };
        let (mut cell, mut number) = (*cell, self.cell);
        let (mut highest, mut slowest) = (f64::INFINITY, cell.speed);
        for _ in 0..AHEAD {
            let chaser = Chaser { limits, period: self.period };
            let beyond = if is_back { number.checked_sub(1) } else { Some(number + 1) };
            let next = beyond.and_then(|n| Some((n, track.cell(n)?)));
            // A stop is at the end of its cell.
            let next = next.filter(|(_, next)| if is_back { !next.stop } else { !cell.stop });
            let Some((n, next)) = next else {
                if chaser.allows(now, wanted, distance, 0.0) && distance > self.step_back() {
                    return highest;
                }
                let end = chaser.toward(now, Aim { distance, speed: 0.0 });
                return if end < highest { end } else { highest };
            };
            // The low limits are those of the cells ahead already.
            if is_back || !self.is_low {
                limits = lower(limits, self.limits_of(track, &next, velocity));
            }
            if next.speed < slowest {
                slowest = next.speed;
                let chaser = Chaser { limits, period: self.period };
                let (distance, speed) = (self.early(distance), SLOWER * slowest);
                if !chaser.allows(now, wanted, distance, speed) {
                    let a = chaser.before(now, distance, speed);
                    highest = if a < highest { a } else { highest };
                }
            }
            distance += next.length;
            (cell, number) = (next, n);
        }
        highest
    }

    /// Returns the limits along the path in a cell, at this velocity.
    pub(super) fn limits_of(&self, track: &impl Path, cell: &Cell, velocity: f64) -> Limits {
        let limits = self.limits_of_curve(cell, velocity);
        let (is_straight, own) = self.jerk_of(track, cell.curve);
        if !is_straight {
            return limits;
        }
        let [acceleration, jerk] = CURVED;
        let filtered = limits.jerk / jerk;
        let jerk = if own > filtered { own } else { filtered } * SHARE;
        Limits { acceleration: limits.acceleration / acceleration, jerk, ..limits }
    }

    /// Returns the limits along the path in a cell at this velocity, as far as curves of any kind may use them.
    fn limits_of_curve(&self, cell: &Cell, velocity: f64) -> Limits {
        let velocity = fabs(velocity) + cell.rest * self.period;
        // A motion that is faster is slower there.
        let velocity = if velocity < cell.speed { velocity } else { cell.speed };
        let fade = cell.fade * velocity * velocity;
        let least = LEAST * cell.rest;
        let acceleration = if cell.rest - fade > least { cell.rest - fade } else { least };
        let filtered = cell.rest / (f64::from(cell.samples) * self.period);
        let jerk = if cell.samples > 1 { filtered } else { f64::INFINITY };
        let [acceleration, jerk] = [acceleration * CURVED[0], jerk * CURVED[1]];
        let velocity = cell.topped(&self.tops).min(cell.speed);
        Limits { velocity, acceleration, jerk }
    }

    /// Returns whether a curve is a straight line, and the highest jerk along it; 0 if the axes alone do not tell it.
    fn jerk_of(&self, track: &impl Path, number: u64) -> (bool, f64) {
        // A line is straight in joints only where each follows an axis.
        let is_known = self.jerks.is_some();
        let is_straight = |curve: &Curve| is_known && matches!(curve, Curve::Line { .. });
        let known = self.curve.as_ref().filter(|(known, ..)| *known == number);
        if let Some((_, curve, jerk)) = known {
            return (is_straight(curve), *jerk);
        }
        track.curve(number).map_or((false, 0.0), |c| (is_straight(&c), self.jerk_along(&c)))
    }

    pub(super) fn jerk_along(&self, curve: &Curve) -> f64 {
        let (Some(jerks), Curve::Line { slope, .. }) = (&self.jerks, curve) else { return 0.0 };
        let axes = jerks.iter().zip(&slope.0).filter(|(_, slope)| **slope != 0.0);
        axes.map(|(jerk, slope)| jerk / fabs(*slope)).fold(self.path_jerk, f64::min)
    }
}

const fn lower(a: Limits, b: Limits) -> Limits {
    Limits {
        velocity: a.velocity.min(b.velocity),
        acceleration: a.acceleration.min(b.acceleration),
        jerk: a.jerk.min(b.jerk),
    }
}

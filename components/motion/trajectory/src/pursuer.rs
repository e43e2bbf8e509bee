//! Realtime. The pursuer: moves along a track after a place that a spindle gives, without delay.
//!
//! A filter would delay the axes against the spindle. The pursuer has none: in each period it chooses an acceleration that the
//! limits of velocity, acceleration and jerk allow ([`Chaser`]), and from which it can still come to rest at the end of the
//! track and be slow enough for the cells ahead.

use crate::{
    chaser::{Aim, Chaser, Rates},
    curve::Curve,
    follower::Step,
    machine::Limits,
    pose::{AXES, Pose},
    track::{Cell, Path},
};
use libm::fabs;

/// Largest number of cells ahead whose limits count.
const AHEAD: u32 = 64;

/// A way that is rounding: nothing moves for it.
const NO_WAY: f64 = 1e-13;

/// Distance from the end of a cell at which a motion at rest is there.
const AT_END: f64 = 1e-9;

/// Part of the limits of jerk in use, so that rounding is no violation.
const SHARE: f64 = 1.0 - 1e-5;

/// Parts of acceleration and jerk in use along curves, whose limits are those of continuous motion and not of periods.
const CURVED: [f64; 2] = [0.85, 0.75];

/// Part of the speed of a cell in use beside curves, and with which a slower cell is entered.
const SLOWER: f64 = 0.99;

/// Periods by which the motion is slow enough before a slower cell.
const EARLY: f64 = 1.5;

/// Number of periods beside a curve in which its limits count besides those of the plan's filter: a third difference spans them.
const BESIDE: u32 = 4;

/// Part of the acceleration at rest that is left at any speed, so that a motion can always brake.
const LEAST: f64 = 0.02;

/// Moves along a track after a place, one servo period at a time.
#[derive(Clone, Debug)]
pub struct Pursuer {
    period: f64,
    /// Highest jerks of the axes along straight lines; `None` if the cells alone know them.
    jerks: Option<[f64; AXES]>,
    path_jerk: f64,
    cell: u64,
    /// Distance to the end of the cell.
    to_go: f64,
    begun: bool,
    skip: f64,
    /// Highest speed along the path, whatever was planned.
    top: f64,
    now: Rates,
    /// Periods since the place was on a curve.
    since_curve: u32,
    /// Periods of rest at the end of a cell.
    at_rest: u32,
    /// True while the limits of curves count.
    is_low: bool,
    position: Pose,
    shown: Option<Cell>,
    /// Curve at the place, with its number and its jerk along the path.
    curve: Option<(u64, Curve, f64)>,
}

/// Goal of a pursuit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pursuit {
    /// Come to rest as soon as possible.
    Rest,
    /// Be at a place, forward only.
    Forward(Aim),
    /// Be at a place, forward or back.
    Both(Aim),
}

impl Pursuer {
    /// Pursuer at rest at the start of a track, at this pose, with a period in seconds. `jerks` are the highest jerks of the
    /// axes, if straight lines need no others; `path_jerk` is the one along the path.
    pub const fn new(period: f64, start: Pose, jerks: Option<[f64; AXES]>, path_jerk: f64) -> Self {
        Self {
            period,
            jerks,
            path_jerk,
            cell: 0,
            to_go: 0.0,
            begun: false,
            skip: 0.0,
            top: f64::INFINITY,
            now: Rates { velocity: 0.0, acceleration: 0.0 },
            since_curve: u32::MAX,
            at_rest: 0,
            is_low: false,
            position: start,
            shown: None,
            curve: None,
        }
    }

    /// Begins at this distance from the start of the track instead. The pose there is the one given to [`Self::new`].
    #[must_use]
    pub const fn begin_at(mut self, distance: f64) -> Self {
        self.skip = if distance > 0.0 { distance } else { 0.0 };
        self
    }

    /// Limits the speed along the path from now on, in units per second. A motion that is faster brakes.
    pub const fn limit(&mut self, top: f64) {
        self.top = if top > 0.0 { top } else { 0.0 };
    }

    /// Advances by one period.
    pub fn step(&mut self, track: &impl Path, goal: Pursuit) -> Step {
        let mut travel = 0.0;
        if let Some(cell) = self.enter(track) {
            let a = self.acceleration(track, &cell, goal);
            let h = self.period;
            let velocity = self.now.velocity + a * h;
            let velocity = if fabs(velocity) * h <= NO_WAY { 0.0 } else { velocity };
            self.now = Rates { velocity, acceleration: a };
            travel = self.advance(track, &cell, velocity * h);
        }
        track.release(self.cell);
        let rests = self.now.velocity == 0.0;
        Step {
            pose: self.position,
            line: self.shown.map_or(0, |c| c.line),
            travel,
            feed: self.shown.map_or(0.0, |c| c.programmed()),
            highest: self.shown.map_or(0.0, |c| c.speed),
            moving: !rests || fabs(self.now.acceleration) > 0.0,
            rests,
        }
    }

    /// Returns true if the pursuer rests at the end of the track.
    pub fn is_done(&self, track: &impl Path) -> bool {
        self.now.velocity == 0.0
            && self.now.acceleration == 0.0
            && !track.has(self.cell + 1)
            && (self.begun && fabs(self.to_go) <= AT_END || track.cell(self.cell).is_none())
    }

    /// Returns the cell, and the distance from its start.
    pub fn input(&self, track: &impl Path) -> (u64, f64) {
        let gone = track.cell(self.cell).filter(|_| self.begun);
        (self.cell, gone.map_or(0.0, |cell| cell.length - self.to_go))
    }

    /// Returns the limits along the path at the place; `None` if there is no path yet.
    pub fn limits(&self, track: &impl Path) -> Option<Limits> {
        let cell = track.cell(self.cell)?;
        Some(self.limits_of(track, &cell, 0.0))
    }

    /// Returns the cell of the place, which is the next one if the motion rests at the end of a cell.
    fn enter(&mut self, track: &impl Path) -> Option<Cell> {
        let mut cell = track.cell(self.cell)?;
        if !self.begun {
            self.begun = true;
            while self.skip > cell.length
                && let Some(next) = track.cell(self.cell + 1)
            {
                self.skip -= cell.length;
                self.cell += 1;
                cell = next;
            }
            self.to_go = cell.length - self.skip;
        }
        self.at_rest = match self.now.velocity == 0.0 && fabs(self.to_go) <= AT_END {
            true => self.at_rest.saturating_add(1),
            false => 0,
        };
        // The path may turn at a stop.
        if self.at_rest > if cell.stop { BESIDE } else { 0 }
            && let Some(next) = track.cell(self.cell + 1)
        {
            self.cell += 1;
            self.to_go = next.length;
            cell = next;
        }
        Some(cell)
    }

    /// Returns the acceleration of this period.
    fn acceleration(&mut self, track: &impl Path, cell: &Cell, goal: Pursuit) -> f64 {
        let now = self.now;
        let limits = self.limits_here(track, cell);
        let chaser = Chaser { limits, period: self.period };
        let wanted = match goal {
            Pursuit::Rest => chaser.at_velocity(now, 0.0),
            Pursuit::Forward(aim) | Pursuit::Both(aim) => chaser.toward(now, aim),
        };
        let highest = self.highest(track, cell, limits, wanted);
        let a = if wanted < highest { wanted } else { highest };
        if now.velocity < 0.0 {
            let back = self.highest_back(track, cell, limits, -a);
            return if -a < back { a } else { -back };
        }
        // A motion that is a rounding beyond an end comes back to it.
        if matches!(goal, Pursuit::Both(_)) || self.to_go < 0.0 {
            return a;
        }
        let lowest = chaser.at_velocity(now, 0.0);
        if a < lowest { lowest } else { a }
    }

    /// Returns the way that is left before an end as soon as it counts exactly.
    fn step_back(&self) -> f64 {
        4.0 * fabs(self.now.velocity) * self.period
    }

    /// Returns a distance less the way of the period in which a cell is entered.
    fn early(&self, distance: f64) -> f64 {
        distance - EARLY * fabs(self.now.velocity) * self.period
    }

    /// Returns the limits of this period. Those of the curves ahead, and of one behind as far as the plan's own limits reach, count from
    /// the moment in which the motion is calm enough for them.
    fn limits_here(&mut self, track: &impl Path, cell: &Cell) -> Limits {
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

    /// Returns the highest acceleration that the rest of the track allows to a motion that wants this one.
    fn highest(&self, track: &impl Path, cell: &Cell, mut limits: Limits, wanted: f64) -> f64 {
        let (mut cell, mut number, mut distance) = (*cell, self.cell, self.to_go);
        let (mut highest, mut slowest) = (f64::INFINITY, cell.speed);
        for _ in 0..AHEAD {
            let chaser = Chaser { limits, period: self.period };
            let next = if cell.stop { None } else { track.cell(number + 1) };
            let Some(next) = next else {
                if chaser.allows(self.now, wanted, distance, 0.0) && distance > self.step_back() {
                    return highest;
                }
                let end = chaser.toward(self.now, Aim { distance, speed: 0.0 });
                return if end < highest { end } else { highest };
            };
            if !self.is_low {
                limits = lower(limits, self.limits_of(track, &next, self.now.velocity));
            }
            if next.speed < slowest {
                slowest = next.speed;
                let chaser = Chaser { limits, period: self.period };
                let (distance, speed) = (self.early(distance), SLOWER * slowest);
                if !chaser.allows(self.now, wanted, distance, speed) {
                    let a = chaser.before(self.now, distance, speed);
                    highest = if a < highest { a } else { highest };
                }
            }
            distance += next.length;
            (cell, number) = (next, number + 1);
        }
        highest
    }

    /// Returns the highest acceleration backwards that the track behind allows to a motion that goes back and wants this one.
    fn highest_back(&self, track: &impl Path, cell: &Cell, mut limits: Limits, wanted: f64) -> f64 {
        let back = Rates { velocity: -self.now.velocity, acceleration: -self.now.acceleration };
        let (mut number, mut distance) = (self.cell, cell.length - self.to_go);
        let (mut highest, mut slowest) = (f64::INFINITY, cell.speed);
        for _ in 0..AHEAD {
            let chaser = Chaser { limits, period: self.period };
            let before = number.checked_sub(1).and_then(|n| track.cell(n)).filter(|c| !c.stop);
            let Some(before) = before else {
                if chaser.allows(back, wanted, distance, 0.0) && distance > self.step_back() {
                    return highest;
                }
                let end = chaser.toward(back, Aim { distance, speed: 0.0 });
                return if end < highest { end } else { highest };
            };
            if before.speed < slowest {
                slowest = before.speed;
                let (distance, speed) = (self.early(distance), SLOWER * slowest);
                if !chaser.allows(back, wanted, distance, speed) {
                    let a = chaser.before(back, distance, speed);
                    highest = if a < highest { a } else { highest };
                }
            }
            limits = lower(limits, self.limits_of(track, &before, self.now.velocity));
            distance += before.length;
            number -= 1;
        }
        highest
    }

    /// Returns the limits along the path in a cell, at this velocity.
    fn limits_of(&self, track: &impl Path, cell: &Cell, velocity: f64) -> Limits {
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
        let velocity = if self.top < cell.speed { self.top } else { cell.speed };
        Limits { velocity, acceleration, jerk }
    }

    /// Returns whether a curve is a straight line, and the highest jerk along it; 0 if the axes alone do not tell it.
    fn jerk_of(&self, track: &impl Path, number: u64) -> (bool, f64) {
        let is_straight = |curve: &Curve| matches!(curve, Curve::Line { .. });
        let known = self.curve.as_ref().filter(|(known, ..)| *known == number);
        if let Some((_, curve, jerk)) = known {
            return (is_straight(curve), *jerk);
        }
        track.curve(number).map_or((false, 0.0), |c| (is_straight(&c), self.jerk_along(&c)))
    }

    fn jerk_along(&self, curve: &Curve) -> f64 {
        let (Some(jerks), Curve::Line { slope, .. }) = (&self.jerks, curve) else { return 0.0 };
        let axes = jerks.iter().zip(&slope.0).filter(|(_, slope)| **slope != 0.0);
        axes.map(|(jerk, slope)| jerk / fabs(*slope)).fold(self.path_jerk, f64::min)
    }

    /// Moves along the track. Returns the travel.
    fn advance(&mut self, track: &impl Path, cell: &Cell, travel: f64) -> f64 {
        let mut cell = *cell;
        self.to_go -= travel;
        for _ in 0..AHEAD {
            // A way that is rounding does not leave the cell.
            if fabs(self.to_go) <= NO_WAY * (1.0 + cell.length) {
                self.to_go = 0.0;
            }
            if self.to_go < 0.0 {
                let next = if cell.stop { None } else { track.cell(self.cell + 1) };
                let Some(next) = next else { break };
                self.cell += 1;
                self.to_go += next.length;
                cell = next;
            } else if self.to_go > cell.length {
                let before = self.cell.checked_sub(1);
                let Some((n, before)) = before.and_then(|n| Some((n, track.cell(n)?))) else {
                    break;
                };
                self.to_go -= cell.length;
                self.cell = n;
                cell = before;
            } else {
                break;
            }
        }
        self.show(track, &cell);
        travel
    }

    /// Finds the pose of the place, which is in this cell.
    fn show(&mut self, track: &impl Path, cell: &Cell) {
        if self.curve.as_ref().is_none_or(|(number, ..)| *number != cell.curve) {
            let Some(curve) = track.curve(cell.curve) else { return };
            self.curve = Some((cell.curve, curve, self.jerk_along(&curve)));
        }
        let Some((_, curve, _)) = &self.curve else { return };
        self.position = curve.pose(cell.from + (cell.length - self.to_go));
        self.shown = Some(*cell);
    }
}

const fn lower(a: Limits, b: Limits) -> Limits {
    Limits {
        velocity: a.velocity.min(b.velocity),
        acceleration: a.acceleration.min(b.acceleration),
        jerk: a.jerk.min(b.jerk),
    }
}

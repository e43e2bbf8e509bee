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
    tops::Tops,
    track::{Cell, Path},
};
use libm::fabs;

mod limits;

/// Largest number of cells ahead whose limits count.
const AHEAD: u32 = 64;

/// A way that is rounding: nothing moves for it.
const NO_WAY: f64 = 1e-13;

/// Distance from the end of a cell at which a motion at rest is there.
const AT_END: f64 = 1e-9;

/// Periods by which the motion is slow enough before a slower cell.
const EARLY: f64 = 1.5;

/// Number of periods beside a curve in which its limits count besides those of the plan's filter: a third difference spans them.
const BESIDE: u32 = 4;

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
    /// Highest speeds, whatever was planned.
    tops: Tops,
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
            tops: Tops::NONE,
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

    /// Limits the speed from now on. A motion that is faster brakes.
    pub const fn limit(&mut self, tops: Tops) {
        self.tops = tops.usable();
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
            lead: self.shown.map_or(1.0, |c| f64::from(c.lead)),
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
        let highest = self.highest(track, cell, limits, wanted, false);
        let a = if wanted < highest { wanted } else { highest };
        if now.velocity < 0.0 {
            let back = self.highest(track, cell, limits, -a, true);
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

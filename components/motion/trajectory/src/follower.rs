//! Realtime. The follower: walks along the track below its speeds, at any override, and filters the jerk.
//!
//! The follower keeps a place on the track and a speed. In each period it accelerates, cruises or brakes with the
//! accelerations that the cells allow, below the curve of highest speeds. The travel per period goes through a moving
//! average, and the averaged travel moves the output along the same track. The filter moves the output along the path,
//! never off it.
//!
//! Where the jerk is limited, the input cruises between acceleration and deceleration for as long as the filter looks
//! back (the pause). The filter then never sees both, and its length T bounds the jerk by a/T instead of 2a/T. To be able
//! to pause, the input accelerates only to speeds at which it could cruise for the whole pause below the curve of highest
//! speeds.

mod ahead;
mod event;
mod output;

use ahead::Alike;

use crate::{
    curve::Curve,
    pose::Pose,
    scales::Scales,
    speed::MAX_SAMPLES,
    tops::Tops,
    track::{Cell, Path},
};

/// Largest number of changes of acceleration in a period. A cell border is one.
const MAX_EVENTS: u32 = 96;

/// A way that is rounding: nothing moves for it.
const NO_WAY: f64 = 1e-13;

/// Periods of rest, beyond the length of the filter, before motion leaves an exact stop under a limit of jerk. Without
/// one, motion leaves it in the next period: decelerations and accelerations that follow each other at rest are within
/// their limits, also as finite differences.
const REST: u32 = 3;

/// Walks along a track, one servo period at a time.
#[derive(Clone, Debug)]
pub struct Follower {
    period: f64,
    /// Cell of the input, and the distance to its end in the direction of motion. The distance is kept, and not the
    /// place from the other end, so that it is exact near the end.
    cell: u64,
    to_go: f64,
    begun: bool,
    speed: f64,
    back: bool,
    output: TrackPosition,
    /// Rounding of the output's place that is still to be made good.
    carry: f64,
    ring: Box<[f64]>,
    samples: usize,
    next: usize,
    sum: f64,
    flat: u32,
    /// Time since the last acceleration and the last deceleration of the input.
    since_up: f64,
    since_down: f64,
    recheck: u8,
    /// Cells ahead that are of the kinds of the input's cell.
    alike: Alike,
    /// True if reverse motion was asked for.
    asked: bool,
    events: u32,
    position: Pose,
    line: u32,
    /// Programmed and highest speed of the cell at the output.
    feed: f64,
    highest: f64,
    /// Speed of its lead group, at a speed of 1 along the path.
    lead: f64,
    /// Highest speeds, whatever was planned.
    tops: Tops,
    /// Distance from the start of the track at which the motion begins.
    skip: f64,
    /// Travel in the last period.
    travel: f64,
    /// True if the input brakes for what is ahead.
    brakes: bool,
    /// Curve at the output, and its number.
    curve: Option<(u64, Curve)>,
}

/// A place on the track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct TrackPosition {
    cell: u64,
    /// Path coordinate from the start of the cell.
    x: f64,
}

/// Result of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Pose at the end of the period.
    pub pose: Pose,
    /// Line of the program at this pose.
    pub line: u32,
    /// Travel in this period, in units of the path coordinate; negative in reverse.
    pub travel: f64,
    /// Speed of the group that governs the feed, at a speed of 1 along the path.
    pub lead: f64,
    /// Programmed speed at this pose, in units of the path coordinate per second.
    pub feed: f64,
    /// Highest planned speed at this pose, in units of the path coordinate per second.
    pub highest: f64,
    /// True while the follower or its filter moves, and in the period in which it comes to rest under a limit of jerk.
    pub moving: bool,
    /// True if the speed is 0 at the end of the period, as it is at an exact stop.
    pub rests: bool,
}

impl Follower {
    /// Follower at rest at the start of a track, at this pose, with a period in seconds.
    pub fn new(period: f64, start: Pose) -> Self {
        Self {
            period,
            cell: 0,
            to_go: 0.0,
            begun: false,
            speed: 0.0,
            back: false,
            output: TrackPosition::default(),
            carry: 0.0,
            ring: vec![0.0; usize::from(MAX_SAMPLES)].into_boxed_slice(),
            samples: 1,
            next: 0,
            sum: 0.0,
            flat: u32::from(MAX_SAMPLES),
            since_up: f64::INFINITY,
            since_down: f64::INFINITY,
            recheck: 0,
            alike: Alike::none(0),
            asked: false,
            events: 0,
            position: start,
            line: 0,
            feed: 0.0,
            highest: 0.0,
            lead: 1.0,
            tops: Tops::NONE,
            skip: 0.0,
            travel: 0.0,
            brakes: false,
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

    /// Advances by one period at these overrides. `reverse` moves back along the path.
    ///
    /// An override of 0 holds the moves of its kind: the motion stops inside them, or before them if it sees them in time.
    /// Blends between both kinds keep both overrides.
    pub fn step(&mut self, track: &impl Path, scales: impl Into<Scales>, reverse: bool) -> Step {
        let moved = self.walk(track, &scales.into().usable(), reverse);
        let travel = self.filter(moved);
        // Under a limit of jerk the acceleration must be 0 too, before another planner moves the same axes.
        let comes_to_rest = self.samples > 1 && self.travel != 0.0;
        self.travel = travel;
        self.advance(track, travel);
        track.release(self.oldest());
        Step {
            pose: self.position,
            line: self.line,
            travel,
            lead: self.lead,
            feed: self.feed,
            highest: self.highest,
            moving: self.speed > 0.0 || !self.is_flat() || comes_to_rest,
            rests: self.speed == 0.0 && (self.samples == 1 || self.is_flat()),
        }
    }

    /// Returns true if the follower rests at the end of the track and the filter is flat.
    pub fn is_done(&self, track: &impl Path) -> bool {
        self.is_flat()
            && !track.has(self.cell + 1)
            && track.cell(self.cell).is_none_or(|c| self.place(&c).x >= c.length)
    }

    /// Returns the largest number of events in a period so far.
    pub const fn events(&self) -> u32 {
        self.events
    }

    /// Returns the number of the oldest cell in use. Reverse motion needs older ones.
    pub fn oldest(&self) -> u64 {
        self.cell.min(self.output.cell)
    }

    /// Returns the cell of the input, and the distance from its start.
    pub fn input(&self, track: &impl Path) -> (u64, f64) {
        (self.cell, track.cell(self.cell).map_or(0.0, |cell| self.place(&cell).x))
    }

    /// Returns the highest acceleration along the path, at rest, at the place of the input; 0 if there is no path yet.
    pub fn acceleration(&self, track: &impl Path) -> f64 {
        track.cell(self.cell).map_or(0.0, |cell| cell.rest)
    }

    /// Returns true if the input brakes for the end of the path, or for a lower speed ahead.
    pub const fn brakes(&self) -> bool {
        self.brakes
    }

    /// Returns the speed of the input along the path.
    pub const fn speed(&self) -> f64 {
        self.speed
    }

    /// Place of the input.
    fn place(&self, cell: &Cell) -> TrackPosition {
        let x = if self.back { self.to_go } else { cell.length - self.to_go };
        TrackPosition { cell: self.cell, x: if self.begun { x } else { 0.0 } }
    }

    fn is_flat(&self) -> bool {
        usize::try_from(self.flat).is_ok_and(|f| f >= self.samples)
    }

    /// Walks the input for one period and returns its travel.
    fn walk(&mut self, track: &impl Path, scales: &Scales, reverse: bool) -> f64 {
        let mut left = self.period;
        let mut moved = 0.0;
        let mut still = true;
        let mut events = 0;
        self.recheck = self.recheck.saturating_sub(1);
        self.brakes = false;
        if self.asked && !reverse && !self.back {
            self.asked = false;
            let _ = track.may_turn(false);
        }
        let ahead = self.cap_ahead(track, scales);
        while left > 0.0 && events < MAX_EVENTS {
            events += 1;
            let Some(mut cell) = track.cell(self.cell) else { break };
            if !self.begun {
                self.begun = true;
                while self.skip > cell.length
                    && let Some(next) = track.cell(self.cell + 1)
                {
                    self.skip -= cell.length;
                    self.cell += 1;
                    cell = next;
                }
                self.to_go = (cell.length - self.skip).max(0.0);
                self.output = self.place(&cell);
            }
            if self.speed == 0.0 && self.back != reverse {
                self.asked = reverse;
                if !track.may_turn(reverse) {
                    break;
                }
                self.back = reverse;
                self.alike = Alike::none(self.cell);
                self.to_go = cell.length - self.to_go;
            }
            if usize::from(cell.samples) != self.samples && !self.change_filter(&cell, still) {
                break;
            }
            if self.to_go <= 0.0 || self.speed == 0.0 && self.to_go <= NO_WAY {
                self.to_go = 0.0;
                if !self.cross(track, &cell, still) {
                    break;
                }
                continue;
            }
            let cap = match self.back == reverse {
                true => cell.scaled(scales).min(ahead).min(cell.topped(&self.tops)),
                false => 0.0,
            };
            let Some((time, distance)) = self.event(track, &cell, cap, left) else { break };
            left -= time;
            self.since_up += time;
            self.since_down += time;
            // The travel is what the place has really moved, rounding included, so that input and output agree in the end.
            let before = self.to_go;
            self.to_go -= distance;
            let distance = before - self.to_go;
            // A stop that is reached in this period needs its full time of rest.
            self.flat = 0;
            still = false;
            moved += if self.back { -distance } else { distance };
        }
        self.events = self.events.max(events);
        // Time at rest counts for the pause.
        if left > 0.0 {
            self.since_up += left;
            self.since_down += left;
        }
        if still {
            self.flat = self.flat.saturating_add(1);
        }
        moved
    }

    /// Goes to the next cell, or waits at a stop. `still` is true while nothing has moved in this period. Returns false if
    /// the input stays.
    fn cross(&mut self, track: &impl Path, cell: &Cell, still: bool) -> bool {
        let (number, floor) = if self.back {
            let Some(number) = self.cell.checked_sub(1) else {
                self.speed = 0.0;
                return false;
            };
            (number, cell.begin)
        } else {
            (self.cell + 1, cell.end)
        };
        self.speed = self.speed.min(floor.sqrt());
        let Some(next) = track.cell(number) else {
            self.speed = 0.0;
            return false;
        };
        // A planner in another thread may have made the cell a stop before it added the next one.
        let cell = track.cell(self.cell).unwrap_or(*cell);
        if if self.back { next.stop } else { cell.stop } {
            self.speed = 0.0;
            if !self.has_rested(still) {
                return false;
            }
        }
        self.cell = number;
        self.alike.length -= next.length;
        self.to_go = next.length;
        true
    }

    /// Takes over the length of the filter from a cell, which needs rest. Returns false if the motion must wait.
    fn change_filter(&mut self, cell: &Cell, still: bool) -> bool {
        self.speed = 0.0;
        if self.has_rested(still) {
            self.samples = usize::from(cell.samples).max(1).min(self.ring.len());
            self.next = 0;
            self.ring.fill(0.0);
            return true;
        }
        false
    }

    /// Returns true if the input has rested for longer than the filter and the third difference look back, or, without a
    /// filter, since the start of this period.
    fn has_rested(&self, still: bool) -> bool {
        let rests = usize::try_from(self.flat.saturating_sub(REST));
        if self.samples == 1 { still } else { rests.is_ok_and(|f| f >= self.samples) }
    }

    /// Averages the travel over the last periods.
    fn filter(&mut self, moved: f64) -> f64 {
        let n = self.samples;
        if let Some(slot) = self.ring.get_mut(self.next) {
            self.sum += moved - *slot;
            *slot = moved;
        }
        self.next += 1;
        if self.next >= n {
            self.next = 0;
            // The sum is formed again once a revolution, so that rounding does not grow.
            self.sum = self.ring.iter().take(n).sum();
        }
        if self.is_flat() {
            self.sum = 0.0;
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 2000")]
        let mean = self.sum / n as f64;
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, Machine, Mode, Move, Planner, Shape, Trivial};
    use hal_corpus::Rng;

    /// A limit of speed that differs from the planned speed by rounding alone stops nothing.
    #[test]
    fn a_limit_within_rounding_of_the_curve() {
        let limits = Limits { velocity: 1e3, acceleration: 500.0, jerk: f64::INFINITY };
        let machine = Machine::uniform(limits);
        for ulps in -4_i64..=4 {
            let mut planner = Planner::new(machine, Trivial, Pose::ZERO).unwrap();
            let shape = Shape::Line { end: Pose::from_xyz([-140.0, 240.0, 65.0]) };
            planner
                .push(&Move { shape, feed: 100.0, rapid: false, mode: Mode::ExactStop, line: 1 })
                .unwrap();
            planner.finish();
            let mut follower = Follower::new(machine.period, Pose::ZERO);
            let linear = f64::from_bits(100.0_f64.to_bits().wrapping_add_signed(ulps));
            follower.limit(Tops { linear, ..Tops::NONE });
            let mut cycles = 0;
            while follower.step(planner.track(), 1.0, false).moving || cycles == 0 {
                cycles += 1;
                assert!(
                    cycles < 4000,
                    "{ulps}: it stands at {:?}",
                    follower.input(planner.track())
                );
            }
            assert!(follower.is_done(planner.track()), "{ulps}");
            assert!(follower.events() < MAX_EVENTS, "{ulps}: {} events", follower.events());
        }
    }

    /// After every period, at any override, the input is below the curve of highest speeds.
    #[test]
    fn the_input_stays_below_the_curve() {
        for seed in 0..40 {
            let mut rng = Rng::new(seed);
            let jerk = rng.pick(&[f64::INFINITY, 1e5, 1e4], 1e5);
            let limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk };
            let machine = Machine::uniform(limits);
            let mut planner = Planner::new(machine, Trivial, Pose::ZERO).unwrap();
            let mut follower = Follower::new(machine.period, Pose::ZERO);
            let (mut scales, mut line) = (Scales::FULL, 0);
            for cycle in 0..6000 {
                if line < 200 && rng.chance(0.1) {
                    let end = Pose::from_xyz([0.0; 3].map(|_: f64| rng.between(-15.0, 15.0)));
                    let shape = Shape::Line { end };
                    let mode = Mode::Blend(0.1);
                    planner
                        .push(&Move { shape, feed: 150.0, rapid: line % 3 == 0, mode, line })
                        .unwrap();
                    line += 1;
                }
                if rng.chance(0.01) {
                    scales.feed = rng.pick(&[0.0, 0.4, 1.0], 1.0);
                }
                if rng.chance(0.01) {
                    scales.rapid = rng.pick(&[0.0, 0.2, 1.0], 1.0);
                }
                let _ = follower.step(planner.track(), scales, false);
                let Some(cell) = planner.track().cell(follower.cell) else { continue };
                let falls = cell.end + 2.0 * cell.braking() * follower.to_go;
                let highest = falls.min(cell.speed * cell.speed);
                let b = follower.speed * follower.speed;
                assert!(b <= highest + 1e-9, "seed {seed} cycle {cycle}: {b} above {highest}");
            }
            assert!(line > 100);
        }
    }
}

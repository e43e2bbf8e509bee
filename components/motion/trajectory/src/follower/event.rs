//! Realtime. One step of the follower's input: up to the next change of its acceleration.

use super::Follower;
use crate::track::{Cell, Path};

/// Periods of the pause beyond the length of the filter: the second difference of the input spans two.
const PAUSE: usize = 2;

/// Largest number of cells that are examined for a pause.
const AHEAD: u32 = 256;

/// Periods between two examinations, after one that allowed no acceleration.
const RECHECK: u8 = 4;

/// Gain of speed, as a share of it, that justifies an acceleration.
const GAIN: f64 = 0.1;

/// Time, in pauses, for which a smaller gain must last.
const LONG: f64 = 10.0;

impl Follower {
    /// Moves up to the next change of acceleration. Returns the time and the distance, and sets the speed; `None` if
    /// nothing moves.
    pub(super) fn event(
        &mut self,
        track: &impl Path,
        cell: &Cell,
        cap: f64,
        left: f64,
    ) -> Option<(f64, f64)> {
        let to_go = self.to_go;
        let (floor, braking) =
            if self.back { (cell.begin, cell.braking_back()) } else { (cell.end, cell.braking()) };
        let top = cell.speed * cell.speed;
        let curve = |to_go: f64| (floor + 2.0 * braking * to_go).min(top);
        let here = curve(to_go);
        let highest = here.sqrt();
        // A speed within rounding of the curve is on it.
        if self.speed > highest * (1.0 - 1e-13) {
            self.speed = highest;
        }
        let v = self.speed;
        // The same for the cap: the curve may be a rounding above it, and a change of speed that small takes no time.
        let is_above = v > cap * (1.0 + 4e-13);
        // Distance on which the curve is level before it falls towards the end of the cell.
        let level = if braking > 0.0 { to_go - (top - floor) / (2.0 * braking) } else { to_go };
        let falling = level <= 1e-13 * to_go;
        let on_curve = v >= highest;
        let allowed = |v: f64| (cell.rest - cell.fade * v * v).max(0.0);
        let mut following = false;
        let mut goal = f64::INFINITY;
        let pause = self.pause();
        // Rounding of times.
        let over = pause - 1e-12;
        // Time until a wanted change of acceleration may begin.
        let mut wait = f64::INFINITY;
        let a = if is_above && (self.since_up >= over || on_curve && falling) {
            let own = if self.since_up >= over { allowed(v) } else { braking };
            -(if falling { own.max(braking) } else { own })
        } else if on_curve && falling {
            following = true;
            self.brakes = true;
            -braking
        } else if is_above {
            wait = pause - self.since_up;
            0.0
        } else if v < cap && !on_curve {
            // The acceleration of a step is the one at its end; a long step is cut, so that it does not vanish.
            let target = cap.min(highest);
            if cell.fade > 0.0 && target - v > 0.005 * target {
                goal = 0.5 * (v + target);
            }
            let up = allowed((v + allowed(v) * left).min(goal).min(cap).min(cell.speed));
            if pause == 0.0 {
                up
            } else if self.since_down < over {
                wait = pause - self.since_down;
                0.0
            } else if self.since_up < self.period || self.is_worth_it(track, cell, target, pause) {
                let target = (v + up * left).min(target).min(goal);
                goal = self.climb(track, cell, target, left + pause);
                if goal > v { up } else { 0.0 }
            } else {
                0.0
            }
        } else {
            0.0
        };
        if v == 0.0 && a <= 0.0 {
            return None;
        }
        let takes = |y: f64| {
            let w = v * v + 2.0 * a * y;
            let sum = v + w.max(0.0).sqrt();
            if w < -1e-12 * v * v || sum <= 0.0 { f64::INFINITY } else { 2.0 * y / sum }
        };
        // The first of: end of the period, end of the cell, end of the level part, cap, curve.
        let (mut time, mut distance, mut speed) = (left, f64::NAN, f64::NAN);
        let mut offer = |t: f64, y: f64, v: f64| {
            if t < time {
                (time, distance, speed) = (t, y, v);
            }
        };
        offer(wait, f64::NAN, v);
        offer(takes(to_go), to_go, f64::NAN);
        if !falling && level < to_go {
            offer(takes(level), level, f64::NAN);
        }
        if is_above && a < 0.0 {
            offer((cap - v) / a, f64::NAN, cap);
        } else if a > 0.0 && cap.min(goal) < highest {
            offer((cap.min(goal) - v) / a, f64::NAN, cap.min(goal));
        }
        if !on_curve && falling && a > -braking {
            let y = (here - v * v) / (2.0 * (a + braking));
            offer(takes(y), y, curve(to_go - y).max(0.0).sqrt());
        } else if !on_curve && a > 0.0 {
            let y = (top - v * v) / (2.0 * a);
            offer(takes(y), y, cell.speed);
        }
        if distance.is_nan() {
            distance = time * (v + 0.5 * a * time);
        }
        let distance = distance.max(0.0).min(to_go);
        self.speed = if following {
            curve(to_go - distance).max(0.0).sqrt()
        } else if speed.is_nan() {
            (v + a * time).max(0.0)
        } else {
            speed
        };
        // The caller adds the time of this step.
        if a > 0.0 {
            self.since_up = -time;
        } else if a < 0.0 {
            self.since_down = -time;
        }
        Some((time, distance))
    }

    /// Returns the time between acceleration and deceleration.
    pub(super) fn pause(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "at most 2002")]
        let periods = (self.samples + PAUSE) as f64;
        if self.samples > 1 { periods * self.period * (1.0 + 1e-9) } else { 0.0 }
    }

    /// Returns true if an acceleration that has not begun gains enough: a higher speed by a share, or a little for long.
    /// Without this rule the input would follow every small rise of the limits along a curve, and the jerk would be noise.
    fn is_worth_it(&mut self, track: &impl Path, cell: &Cell, target: f64, pause: f64) -> bool {
        let v = self.speed;
        if self.recheck > 0 {
            return false;
        }
        let higher = v * (1.0 + GAIN);
        let worth = if higher < target {
            self.is_clear(track, cell, higher, pause)
        } else {
            self.is_clear(track, cell, target, LONG * pause)
        };
        if !worth {
            self.recheck = RECHECK;
        }
        worth
    }

    /// Returns the highest speed up to `target` at which the input could move on for `time` below the curve of highest
    /// speeds; the present speed if there is none above it.
    fn climb(&mut self, track: &impl Path, cell: &Cell, target: f64, time: f64) -> f64 {
        let v = self.speed;
        if self.recheck > 0 {
            return v;
        }
        if self.is_clear(track, cell, target, time) {
            return target;
        }
        let (mut low, mut high) = (v, target);
        for round in 0..45 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.is_clear(track, cell, middle, time) {
                low = middle;
            } else {
                high = middle;
            }
            // Once a speed is found, four more steps are near enough to the highest.
            if low > v && round >= 3 {
                break;
            }
            if v > 0.0 && round >= 3 {
                break;
            }
        }
        self.recheck = RECHECK;
        low
    }

    /// Returns true if the input can move on at this speed for this time below the curve of highest speeds.
    fn is_clear(&self, track: &impl Path, cell: &Cell, speed: f64, time: f64) -> bool {
        let square = speed * speed;
        let mut rest = speed * time;
        let (mut cell, mut number, mut to_go) = (*cell, self.cell, self.to_go);
        for _ in 0..AHEAD {
            let (floor, braking) = if self.back {
                (cell.begin, cell.braking_back())
            } else {
                (cell.end, cell.braking())
            };
            if rest <= to_go {
                return square <= floor + 2.0 * braking * (to_go - rest) && speed <= cell.speed;
            }
            if square > floor {
                return false;
            }
            rest -= to_go;
            let next = if self.back { number.checked_sub(1) } else { Some(number + 1) };
            let Some((k, next)) = next.and_then(|k| Some((k, track.cell(k)?))) else {
                return false;
            };
            (cell, number, to_go) = (next, k, next.length);
        }
        false
    }
}

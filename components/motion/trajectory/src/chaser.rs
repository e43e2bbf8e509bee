//! Realtime. One coordinate that chases a place, which may move, within velocity, acceleration and jerk.
//!
//! A motion is the velocity of a period, which is its travel by its length, and the acceleration, which is the change of
//! that velocity by the same length. So the finite differences of the positions are what the limits are for, without any
//! filter: a coordinate that is at the place stays there without delay.
//!
//! In each period the chaser takes the highest acceleration from which it can still come to rest at the place, relative to it.
//! [`Limits::settle`] has the way of that braking in closed form. Sums of periods differ from integrals over time;
//! [`Chaser::settled`] shifts velocity and place so that both are the same for whole periods.

use crate::machine::Limits;
use libm::{fabs, floor, sqrt};

/// Parts of acceleration and jerk with which the chaser expects to brake. The rest is for phases that end inside a period.
const EXPECTED: [f64; 2] = [0.99, 0.95];

/// Periods that a rise from rest to the full acceleration takes at least, where the jerk has a limit.
const RISE: f64 = 4.0;

/// Part of the way of a single period of jerk by which the chaser comes to rest short of its place, to step there from rest.
const SHORT: f64 = 0.45;

/// Number of halvings in the search for an acceleration.
const HALVINGS: u32 = 26;

/// Velocity and acceleration of a coordinate in a period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Travel by the length of the period.
    pub velocity: f64,
    /// Change of the velocity since the period before, by the length of the period.
    pub acceleration: f64,
}

/// Place that is chased.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Distance from the coordinate, as the period begins, to the place, as the period ends.
    pub distance: f64,
    /// Velocity of the place.
    pub speed: f64,
}

/// Way to rest, relative to a speed.
#[derive(Clone, Copy, Debug)]
struct Way {
    length: f64,
    time: f64,
    /// True if the velocity is above the speed even once the acceleration is 0.
    is_forward: bool,
}

impl Way {
    /// Returns the way beyond a distance at which the speed is reached; below 0 if the velocity does not exceed it.
    fn beyond(&self, distance: f64, speed: f64) -> f64 {
        if self.is_forward { self.length + speed * self.time - distance } else { -1.0 }
    }
}

/// Limits and the length of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chaser {
    /// Limits; infinity is none.
    pub limits: Limits,
    /// Length of a period in seconds.
    pub period: f64,
}

impl Limits {
    /// Returns the way and the time in which a velocity comes to rest, with this acceleration at first.
    fn settle(&self, velocity: f64, acceleration: f64) -> Way {
        let (top, k) = (self.acceleration, self.jerk);
        let rest = velocity + 0.5 * acceleration * fabs(acceleration) / k;
        let sign = if rest < 0.0 { -1.0 } else { 1.0 };
        let (v, a) = (velocity * sign, acceleration * sign);
        let top = if -a > top { -a } else { top };
        let square = k * v + 0.5 * a * a;
        let peak = if square > 0.0 { sqrt(square) } else { 0.0 };
        let peak = if peak < top { peak } else { top };
        let rise = (a + peak) / k;
        let after = v + rise * (a - 0.5 * k * rise);
        let hold = if peak < top { 0.0 } else { (after - 0.5 * peak * peak / k) / peak };
        let hold = if hold > 0.0 { hold } else { 0.0 };
        let way = rise * (v + rise * (0.5 * a - k * rise / 6.0))
            + hold * (after - 0.5 * peak * hold)
            + peak * peak * peak / (6.0 * k * k);
        Way { length: way * sign, time: rise + hold + peak / k, is_forward: rest > 0.0 }
    }
}

impl Chaser {
    /// Returns the acceleration of the coming period on the way to a place that moves evenly.
    pub fn toward(&self, now: Rates, aim: Aim) -> f64 {
        let [low, high] = self.reach(now);
        let a = match self.arrival(now, aim) {
            Some(a) => return a,
            None => {
                let short = self.short_of(aim);
                self.search(now, |way| way.length - short, aim.speed, [low, high])
            }
        };
        self.within_velocity(now, a)
    }

    /// Returns the highest acceleration of the coming period with which the coordinate can be as slow as `speed` at a distance.
    pub fn before(&self, now: Rates, distance: f64, speed: f64) -> f64 {
        self.search(now, |way| way.beyond(distance, speed), speed, self.reach(now))
    }

    /// Returns whether an acceleration of the coming period leaves the coordinate a way to be as slow as `speed` at a distance.
    pub fn allows(&self, now: Rates, a: f64, distance: f64, speed: f64) -> bool {
        self.settled(now, a, speed).beyond(distance, speed) <= 0.0
    }

    /// Returns the longest way on which the coordinate can come to rest, whatever it does in the coming period.
    pub fn farthest(&self, now: Rates) -> f64 {
        let [_, high] = self.reach(now);
        let way = self.settled(now, high, 0.0);
        way.length + (fabs(now.velocity) + high * self.period) * self.period
    }

    /// Returns the acceleration of the coming period on the way to a velocity.
    pub fn at_velocity(&self, now: Rates, velocity: f64) -> f64 {
        let h = self.period;
        let by = velocity - now.velocity;
        let wanted = if self.is_free() {
            by / h
        } else {
            // Whole periods: a velocity rises by k·h² times 1, 2, 3, … as the acceleration falls to 0.
            let unit = self.jerk() * h * h;
            let n = fabs(by) / unit;
            let whole = floor(0.5 * (sqrt(1.0 + 8.0 * n) - 1.0));
            let part = (n - 0.5 * whole * (whole + 1.0)) / (whole + 1.0);
            libm::copysign(self.jerk() * h * (whole + part), by)
        };
        let [low, high] = self.reach(now);
        between(wanted, low, high)
    }

    /// Returns whether the acceleration may change in a period from one limit to the other.
    fn is_free(&self) -> bool {
        self.limits.jerk * self.period >= 2.0 * self.limits.acceleration
    }

    /// Returns the jerk in use: at least a few periods pass from rest to the full acceleration.
    fn jerk(&self) -> f64 {
        let most = self.limits.acceleration / (RISE * self.period);
        if self.is_free() {
            f64::INFINITY
        } else if self.limits.jerk < most {
            self.limits.jerk
        } else {
            most
        }
    }

    /// Returns the largest change of the acceleration in a period. It counts also where both limits of acceleration are nearer to each
    /// other: a limit may have been lowered.
    fn change(&self) -> f64 {
        let jerk = self.jerk();
        (if jerk < self.limits.jerk { jerk } else { self.limits.jerk }) * self.period
    }

    /// Returns the lowest and the highest acceleration of the coming period.
    pub fn reach(&self, now: Rates) -> [f64; 2] {
        let (most, by) = (self.limits.acceleration, self.change());
        let (least, top) = (now.acceleration - by, now.acceleration + by);
        // An acceleration beyond its limit comes back as fast as it may.
        [between(-most, least, top), between(most, least, top)]
    }

    /// Returns an acceleration that keeps the velocity within its limit from now on.
    fn within_velocity(&self, now: Rates, a: f64) -> f64 {
        let top = self.limits.velocity;
        if top == f64::INFINITY {
            return a;
        }
        let (low, high) = (self.at_velocity(now, -top), self.at_velocity(now, top));
        between(a, low, high)
    }

    /// Returns the acceleration that ends the chase: the coordinate is at the place as the period ends, and can stay there.
    fn arrival(&self, now: Rates, aim: Aim) -> Option<f64> {
        let h = self.period;
        let (most, step) = (self.limits.acceleration * h * h, self.change() * h * h);
        let way = aim.distance - aim.speed * h;
        let (before, by) = ((now.velocity - aim.speed) * h, now.acceleration * h * h);
        let is_in_reach = fabs(way - before) <= most
            && fabs(way) <= most
            && fabs(way - before - by) <= step
            && fabs(before - 2.0 * way) <= step
            && fabs(way) <= step
            && fabs(aim.distance) <= self.limits.velocity * h;
        is_in_reach.then(|| (way - before) / (h * h))
    }

    /// Returns a distance a little short of the place, from where it is in reach from rest.
    fn short_of(&self, aim: Aim) -> f64 {
        if self.is_free() {
            return aim.distance;
        }
        // A slow coordinate must reach from there in one period too.
        let step = 0.45 * self.limits.velocity * self.period;
        let short = SHORT * self.jerk() * self.period * self.period * self.period;
        let short = if step < short { step } else { short };
        let ahead = aim.distance - aim.speed * self.period;
        aim.distance - between(ahead, -short, short)
    }

    /// Returns the highest acceleration in a range for which `beyond`, which rises with it, is not above 0. It has the way to
    /// rest relative to a speed.
    fn search(
        &self,
        now: Rates,
        beyond: impl Fn(Way) -> f64,
        speed: f64,
        [mut low, mut high]: [f64; 2],
    ) -> f64 {
        let at = |a: f64| beyond(self.settled(now, a, speed));
        if at(high) <= 0.0 {
            return high;
        }
        if at(low) >= 0.0 {
            return low;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if at(middle) <= 0.0 { low = middle } else { high = middle }
        }
        low
    }

    /// Returns the way from the start of the coming period, and the time from its end, to rest relative to a speed, with an
    /// acceleration in that period.
    fn settled(&self, now: Rates, a: f64, speed: f64) -> Way {
        let h = self.period;
        let [acceleration, jerk] = EXPECTED;
        let expected = Limits {
            acceleration: self.limits.acceleration * acceleration,
            jerk: self.jerk() * jerk,
            ..self.limits
        };
        let velocity = now.velocity + a * h;
        let w = velocity - speed;
        let (way, shift) = if self.is_free() {
            // Whole periods of braking, and a part of one.
            let unit = self.limits.acceleration * h;
            let n = fabs(w) / unit;
            let whole = floor(n);
            let way = unit * h * whole * (n - 0.5 * (whole + 1.0));
            let length = libm::copysign(way, w);
            (Way { length, time: n * h, is_forward: w > 0.0 }, 0.0)
        } else {
            let even = w - 0.5 * h * a;
            (expected.settle(even, a), -h * even - h * h * a / 3.0)
        };
        Way { length: velocity * h + shift + way.length, ..way }
    }
}

const fn between(x: f64, low: f64, high: f64) -> f64 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_corpus::Rng;

    const H: f64 = 1e-3;

    /// Machines: velocity, acceleration and jerk.
    const MACHINES: [[f64; 3]; 11] = [
        // So slow that a period of the jerk is a longer way than one of the velocity.
        [0.05, 1000.0, 3e5],
        [0.3, 5000.0, 1e6],
        [100.0, 1000.0, 1e3],
        [5.0, 1000.0, 1e4],
        [100.0, 50.0, 5e4],
        [0.5, 3000.0, 5e4],
        [100.0, 1000.0, 5e4],
        [150.0, 1750.0, 1e5],
        [100.0, 1000.0, 3e5],
        [100.0, 1000.0, 3e6],
        [100.0, 1000.0, f64::INFINITY],
    ];

    /// A coordinate that asserts its limits.
    struct Mover {
        chaser: Chaser,
        now: Rates,
        at: f64,
    }

    impl Mover {
        fn new([velocity, acceleration, jerk]: [f64; 3]) -> Self {
            let limits = Limits { velocity, acceleration, jerk };
            Self { chaser: Chaser { limits, period: H }, now: Rates::default(), at: 0.0 }
        }

        fn go(&mut self, acceleration: f64) {
            let Limits { velocity: v, acceleration: a, jerk: j } = self.chaser.limits;
            let velocity = self.now.velocity + acceleration * H;
            let change = acceleration - self.now.acceleration;
            assert!(velocity.abs() <= v * (1.0 + 1e-12), "velocity {velocity} of {v}");
            assert!(acceleration.abs() <= a * (1.0 + 1e-12), "acceleration {acceleration} of {a}");
            assert!(change.abs() <= j * H * (1.0 + 1e-12), "jerk {} of {j}", change / H);
            self.at += velocity * H;
            self.now = Rates { velocity, acceleration };
        }

        fn rests(&self) -> bool {
            self.now.velocity.abs() < 1e-9 && self.now.acceleration.abs() < 1e-6
        }
    }

    /// Returns the least time of a way from rest to rest.
    fn least(way: f64, [v, a, j]: [f64; 3]) -> f64 {
        let ramp =
            |v: f64| if v * j > a * a { v / a + a / j } else { 2.0 * (v / j).max(0.0).sqrt() };
        if v * ramp(v) <= way {
            return ramp(v) + way / v;
        }
        let (mut low, mut high) = (0.0, v);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle * ramp(middle) < way { low = middle } else { high = middle }
        }
        2.0 * ramp(low)
    }

    #[test]
    fn a_place_is_reached_in_the_least_time_without_overshoot() {
        for machine in MACHINES {
            for seed in 0..200 {
                let mut rng = Rng::new(seed);
                let mut mover = Mover::new(machine);
                let way = 10.0_f64.powf(rng.between(-6.0, 2.0)).min(20.0 * machine[0]);
                let mut periods = 0;
                while periods == 0 || !mover.rests() {
                    let aim = Aim { distance: way - mover.at, speed: 0.0 };
                    mover.go(mover.chaser.toward(mover.now, aim));
                    assert!(mover.at - way < 1e-6, "{machine:?} {way}: {} beyond", mover.at - way);
                    periods += 1;
                    assert!(periods < 100_000, "{machine:?} {way}: never");
                }
                assert!((mover.at - way).abs() < 1e-9, "{machine:?} {way}: at {}", mover.at);
                let least = least(way, machine);
                let late = f64::from(periods) * H - least;
                assert!(
                    late < 0.01 + 0.02 * least,
                    "{machine:?} {way}: {late} s later than {least}"
                );
            }
        }
    }

    /// Places and speeds that change at any time break no limit, and the last place is reached.
    #[test]
    fn a_goal_that_changes_in_motion_breaks_no_limit() {
        for machine in MACHINES {
            for seed in 0..100 {
                let mut rng = Rng::new(seed);
                let mut mover = Mover::new(machine);
                let mut aim_at = 0.0;
                for _ in 0..30 {
                    let size = 10.0_f64.powf(rng.between(-6.0, 1.5)).min(20.0 * machine[0]);
                    aim_at = mover.at + if rng.chance(0.5) { size } else { -size };
                    let (speed, brakes) = (rng.between(-0.8, 0.8) * machine[0], rng.chance(0.2));
                    let speed = if rng.chance(0.5) { 0.0 } else { speed };
                    for _ in 0..rng.pick(&[1, 3, 20, 200], 3) {
                        aim_at += speed * H;
                        let aim = Aim { distance: aim_at - mover.at, speed };
                        let a = match brakes {
                            true => mover.chaser.at_velocity(mover.now, 0.0),
                            false => mover.chaser.toward(mover.now, aim),
                        };
                        mover.go(a);
                    }
                }
                let mut periods = 0;
                while !mover.rests() || (mover.at - aim_at).abs() > 1e-9 {
                    let aim = Aim { distance: aim_at - mover.at, speed: 0.0 };
                    mover.go(mover.chaser.toward(mover.now, aim));
                    periods += 1;
                    assert!(periods < 200_000, "{machine:?} {seed}: never");
                }
            }
        }
    }

    /// A velocity is reached exactly, and never exceeded.
    #[test]
    fn a_velocity_is_reached_exactly() {
        for machine in MACHINES {
            for part in [1e-6, 1e-3, 0.3, 1.0] {
                let (mut mover, goal) = (Mover::new(machine), part * machine[0]);
                for period in 0.. {
                    mover.go(mover.chaser.at_velocity(mover.now, goal));
                    let off = goal - mover.now.velocity;
                    assert!(off > -1e-9 * goal, "{machine:?} {goal}: {off}");
                    if off.abs() <= 1e-9 * goal && mover.now.acceleration.abs() < 1e-6 {
                        break;
                    }
                    assert!(period < 100_000);
                }
            }
        }
    }

    /// A place that moves evenly is caught, and then followed without a distance.
    #[test]
    fn an_even_motion_is_followed_without_a_distance() {
        for machine in MACHINES {
            let mut mover = Mover::new(machine);
            let speed = 0.6 * machine[0];
            let mut place = 0.0;
            let mut since = 0;
            for period in 0.. {
                place += speed * H;
                let aim = Aim { distance: place - mover.at, speed };
                mover.go(mover.chaser.toward(mover.now, aim));
                since = if (place - mover.at).abs() < 1e-9 { since + 1 } else { 0 };
                assert!(period < 100_000, "{machine:?}: {}", place - mover.at);
                if since == 100 {
                    break;
                }
            }
        }
    }
}

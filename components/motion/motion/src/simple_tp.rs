//! Realtime. Planner of one coordinate that moves to a target, within a velocity, an acceleration and a jerk limit.

use hal_trajectory::{Aim, Chaser, Limits, Rates};
use libm::{copysign, fabs, sqrt};

/// A way that is rounding: nothing moves for it.
const NO_WAY: f64 = 1e-13;

/// The planner. Its limits and target may change in motion: it brakes and reverses within its limits, which may take it beyond
/// the target. Under a jerk limit, its acceleration changes within that limit, too, and it comes to rest exactly at the target.
#[derive(Debug, Default)]
pub(crate) struct SimpleTp {
    /// Target; equals the position while the planner is switched off.
    pub(crate) target: f64,
    /// Velocity limit, not negative.
    pub(crate) max_vel: f64,
    /// Acceleration limit, not negative.
    pub(crate) max_acc: f64,
    /// Jerk limit, above 0; 0 or infinite for none.
    pub(crate) max_jerk: f64,
    /// FALSE brakes to a stop.
    pub(crate) enable: bool,
    /// Current position.
    pub(crate) pos: f64,
    /// Current velocity.
    pub(crate) vel: f64,
    /// True while moving, or away from the target.
    pub(crate) active: bool,
    /// Velocity of the cycle before, while the acceleration counts.
    before: f64,
}

impl SimpleTp {
    /// Stops at a position and switches the planner off.
    pub(crate) fn reset(&mut self, pos: f64) {
        (self.pos, self.target) = (pos, pos);
        (self.vel, self.before) = (0.0, 0.0);
        self.enable = false;
        self.active = false;
    }

    /// Sets the position to a value, in motion or at rest; the target keeps its distance.
    pub(crate) fn shift(&mut self, by: f64) {
        self.pos += by;
        self.target += by;
    }

    /// Runs one cycle. Stops within a deadband of 0.001·a·dt² of the target, under a jerk limit exactly there.
    pub(crate) fn step(&mut self, dt: f64) {
        self.run(dt, false);
    }

    /// Runs one cycle; near the target, it ends exactly there instead of within the deadband.
    pub(crate) fn step_exactly(&mut self, dt: f64) {
        self.run(dt, true);
    }

    fn run(&mut self, dt: f64, exactly: bool) {
        if self.is_off() {
            self.active = false;
            return;
        }
        let before = self.vel;
        if 0.0 < self.max_jerk && self.max_jerk < f64::INFINITY && 0.0 < self.max_acc {
            self.walk_smoothly(dt);
        } else if exactly {
            self.walk_exactly(self.max_acc, dt);
        } else {
            self.walk(self.max_acc, dt);
        }
        self.before = before;
    }

    /// Returns the lowest and the highest place between here, the target, and the places that a motion reaches if it brakes.
    pub(crate) fn extent(&self, dt: f64) -> (f64, f64) {
        let (mut lowest, mut highest) = (self.pos, self.pos);
        let [ahead, behind] = self.rest(dt);
        for place in [self.target, ahead, behind] {
            // A jog without limits has an infinite target.
            if place < lowest && place.is_finite() {
                lowest = place;
            }
            if place > highest && place.is_finite() {
                highest = place;
            }
        }
        (lowest, highest)
    }

    /// Returns the places ahead and behind that a motion reaches at most if it brakes from now on: the acceleration ends
    /// within the jerk limit (`v·t + a·t²/3` with `t = a/j`), then it brakes with the whole acceleration, which takes at most
    /// `v²/2a + v·a/2j`. A deceleration that cannot end in time turns the motion round.
    fn rest(&self, dt: f64) -> [f64; 2] {
        if self.vel == 0.0 && self.before == 0.0 || self.max_acc <= 0.0 {
            return [self.pos; 2];
        }
        let has_jerk = 0.0 < self.max_jerk && self.max_jerk < f64::INFINITY;
        let jerk_time = if has_jerk { self.max_acc / self.max_jerk } else { 0.0 };
        let brakes = |vel: f64| 0.5 * vel * (vel / self.max_acc + jerk_time) + vel * dt;
        let sign = copysign(1.0, if self.vel == 0.0 { -self.before } else { self.vel });
        let (vel, gains) = (fabs(self.vel), sign * (self.vel - self.before) / dt);
        if !has_jerk {
            return [self.pos + sign * brakes(vel), self.pos];
        }
        let time = fabs(gains) / self.max_jerk;
        let change = 0.5 * gains * time;
        if gains > 0.0 {
            let way = time * (vel + gains * time / 3.0) + brakes(vel + change);
            return [self.pos + sign * way, self.pos];
        }
        let turned = -(vel + change);
        let back = if turned > 0.0 { time * turned + brakes(turned) } else { 0.0 };
        [self.pos + sign * brakes(vel), self.pos - sign * back]
    }

    /// Returns the distance from its target at which the planner may come to rest.
    pub(crate) fn deadband(&self, dt: f64) -> f64 {
        tiny(self.max_acc * dt, dt)
    }

    /// Returns whether a cycle would leave everything as it is: at rest, at the very target.
    fn is_off(&self) -> bool {
        let at = self.pos.to_bits();
        // A cycle adds zero, which changes the negative one.
        let is_still =
            (self.vel.to_bits() | self.before.to_bits()) == 0 && (self.pos + 0.0).to_bits() == at;
        at == self.target.to_bits() && is_still
    }

    /// Moves for a cycle within the jerk limit.
    fn walk_smoothly(&mut self, dt: f64) {
        let limits =
            Limits { velocity: self.max_vel, acceleration: self.max_acc, jerk: self.max_jerk };
        let chaser = Chaser { limits, period: dt };
        let acceleration = (self.vel - self.before) / dt;
        let now = Rates { velocity: self.vel, acceleration };
        let distance = self.target - self.pos;
        let a = if self.enable && distance.is_finite() {
            chaser.toward(now, Aim { distance, speed: 0.0 })
        } else if self.enable && !distance.is_nan() {
            chaser.at_velocity(now, copysign(self.max_vel, distance))
        } else {
            chaser.at_velocity(now, 0.0)
        };
        let (before, vel) = (self.vel, self.vel + a * dt);
        self.vel = if fabs(vel) * dt <= NO_WAY { 0.0 } else { vel };
        self.pos += self.vel * dt;
        if !self.enable {
            self.target = self.pos;
        } else if fabs(self.target - self.pos) <= NO_WAY * (1.0 + fabs(self.target)) {
            self.pos = self.target;
        }
        // The acceleration must be 0 too, before another planner moves the same joint.
        let is_still = self.vel == 0.0 && before == 0.0;
        self.active = !is_still || self.enable && self.target - self.pos != 0.0;
    }

    /// Moves for a cycle, without a jerk limit.
    fn walk(&mut self, acc: f64, dt: f64) {
        let max_dv = acc * dt;
        let mut want = 0.0;
        self.active = false;
        if self.enable {
            let error = self.target - self.pos;
            if fabs(error) > tiny(max_dv, dt) {
                self.active = true;
                let speed = sqrt(2.0 * acc * fabs(error) + max_dv * max_dv) - max_dv;
                let speed = less(speed, self.max_vel);
                want = if error > 0.0 { speed } else { -speed };
            }
        } else {
            self.target = self.pos;
        }
        if want > self.vel + max_dv {
            self.vel += max_dv;
        } else if want < self.vel - max_dv {
            self.vel -= max_dv;
        } else {
            self.vel = want;
        }
        if self.vel != 0.0 {
            self.active = true;
        }
        self.pos += self.vel * dt;
        if !self.enable {
            self.target = self.pos;
        }
    }

    /// Moves for a cycle, without a jerk limit; near the target, exactly there.
    fn walk_exactly(&mut self, acc: f64, dt: f64) {
        let max_dv = acc * dt;
        let error = self.target - self.pos;
        let last = error / dt;
        if self.enable
            && fabs(error) <= tiny(max_dv, dt)
            && fabs(last - self.vel) <= max_dv
            && fabs(last) <= self.max_vel
        {
            self.vel = last;
            self.pos = self.target;
            self.active = last != 0.0;
        } else {
            self.walk(acc, dt);
        }
    }

    /// Reduces the motion of the last cycle, which began at `from`, to a part; reduces the velocity to the same part.
    pub(crate) fn slow_down(&mut self, from: f64, factor: f64) {
        self.pos = from + (self.pos - from) * factor;
        self.vel *= factor;
        if !self.enable {
            self.target = self.pos;
        }
    }
}

fn less(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the deadband around the target.
fn tiny(max_dv: f64, dt: f64) -> f64 {
    max_dv * dt * 0.001
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.001;

    fn tp(max_vel: f64, max_acc: f64, target: f64) -> SimpleTp {
        SimpleTp { target, max_vel, max_acc, enable: true, ..SimpleTp::default() }
    }

    /// Runs until the planner is at rest, and checks both limits in every cycle; returns the number of cycles.
    fn run(tp: &mut SimpleTp, step: fn(&mut SimpleTp, f64)) -> usize {
        for n in 1..100_000 {
            let before = (tp.pos, tp.vel);
            step(tp, DT);
            assert!(fabs(tp.vel) <= tp.max_vel * (1.0 + 1e-12));
            assert!(fabs(tp.vel - before.1) <= tp.max_acc * DT * (1.0 + 1e-12));
            assert!(fabs(tp.pos - before.0 - tp.vel * DT) < 1e-12);
            if !tp.active {
                return n;
            }
        }
        panic!("never arrives: {tp:?}")
    }

    #[test]
    fn arrives_within_its_limits() {
        for (vel, acc, target) in [
            (90.0, 1350.0, 10.0),
            (90.0, 1350.0, -0.01),
            (10.0, 35.0, 100.0),
            (10.0, 35.0, 0.001),
            (5.0, 1e6, 3.3),
            (1e-3, 1e-2, 0.01),
        ] {
            let mut rough = tp(vel, acc, target);
            run(&mut rough, SimpleTp::step);
            assert!(fabs(rough.pos - target) <= acc * DT * DT * 0.001, "{vel} {acc} {target}");
            let mut exact = tp(vel, acc, target);
            run(&mut exact, SimpleTp::step_exactly);
            assert_eq!(exact.pos, target);
        }
    }

    #[test]
    fn a_motion_that_brakes_rests_within_its_extent() {
        let mut random = hal_bench::Random::new(7);
        for _ in 0..400 {
            let jerk = random.pick(&[f64::INFINITY, 300.0, 1e4, 1e6]);
            let mut one = SimpleTp { max_jerk: jerk, ..SimpleTp::default() };
            (one.max_vel, one.max_acc, one.enable) =
                (random.between(1.0, 90.0), random.between(10.0, 2000.0), true);
            for _ in 0..20 {
                one.target = random.between(-50.0, 50.0);
                (0..random.below(200)).for_each(|_| one.step(DT));
                let (lowest, highest) = one.extent(DT);
                assert!(lowest <= one.target && one.target <= highest);
                let mut brakes = SimpleTp {
                    enable: false,
                    target: one.target,
                    pos: one.pos,
                    vel: one.vel,
                    before: one.before,
                    active: one.active,
                    ..one
                };
                for _ in 0..20_000 {
                    brakes.step(DT);
                    let place = brakes.pos;
                    assert!(lowest - 1e-9 <= place && place <= highest + 1e-9, "{place}: {one:?}");
                }
                assert_eq!(brakes.vel, 0.0);
            }
        }
    }

    #[test]
    fn takes_the_time_of_a_trapezoid() {
        let mut one = tp(90.0, 1350.0, 100.0);
        let n = run(&mut one, SimpleTp::step_exactly);
        // 100/90 s and one ramp of 90/1350 s, and a few cycles for the end.
        let ideal = (100.0 / 90.0 + 90.0 / 1350.0) / DT;
        let cycles = n as f64;
        assert!(ideal <= cycles && cycles < ideal + 20.0, "{n} cycles, ideal {ideal}");
    }

    #[test]
    fn jerk_stays_within_its_limit() {
        for (jerk, exact) in [(20_000.0, false), (3_000.0, true), (1e6, false), (1_000.0, false)] {
            let mut one = SimpleTp { max_jerk: jerk, ..SimpleTp::default() };
            (one.target, one.max_vel, one.max_acc, one.enable) = (60.0, 90.0, 1350.0, true);
            let (mut vel, mut acc, mut worst, mut top) = (0.0, 0.0, 0.0_f64, 0.0_f64);
            for n in 0..6000 {
                let from = one.pos;
                match n {
                    300 => one.target = -20.0,
                    700 => one.target = 60.0,
                    900 => one.enable = false,
                    1500 => (one.enable, one.target) = (true, 10.0),
                    1520 => one.slow_down(from, 1.0),
                    _ => {}
                }
                if exact {
                    one.step_exactly(DT);
                } else {
                    one.step(DT);
                }
                assert!(fabs(one.pos - from - one.vel * DT) < 1e-12);
                let now = (one.vel - vel) / DT;
                worst = worst.max(fabs(now - acc) / DT);
                top = top.max(fabs(now));
                (vel, acc) = (one.vel, now);
                assert!(-20.01 <= one.pos && one.pos <= 60.01);
            }
            assert!(worst <= jerk * 1.0001 + 2.0, "{worst} of {jerk}");
            assert!(
                top <= 1350.0 * 1.0001 && worst > 0.9 * jerk.min(0.25 * 1350.0 / DT),
                "{top} {worst}"
            );
            assert_eq!((one.active, one.pos), (false, 10.0));
        }
    }

    #[test]
    fn brakes_when_switched_off() {
        let mut one = tp(90.0, 1350.0, f64::INFINITY);
        (0..100).for_each(|_| one.step(DT));
        assert_eq!(one.vel, 90.0);
        one.enable = false;
        let from = one.pos;
        run(&mut one, SimpleTp::step);
        let way = one.pos - from;
        let ideal = 90.0 * 90.0 / 1350.0 / 2.0;
        assert!(fabs(way - ideal) < 90.0 * DT, "{way}");
        assert_eq!(one.target, one.pos);
    }

    #[test]
    fn nonsense_stands_still() {
        for (vel, acc, target) in
            [(1.0, 1.0, f64::NAN), (0.0, 1.0, 5.0), (1.0, 0.0, 5.0), (0.0, 0.0, f64::INFINITY)]
        {
            let mut one = tp(vel, acc, target);
            (0..10).for_each(|_| one.step(DT));
            assert_eq!(one.pos, 0.0, "{vel} {acc} {target}");
        }
    }
}

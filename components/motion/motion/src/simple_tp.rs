//! Realtime. Planner of one coordinate that moves to a target, within a velocity, an acceleration and a jerk limit.

use crate::smooth::Smooth;
use libm::{ceil, fabs, sqrt};

/// The planner. Its limits and target may change in motion: it brakes and reverses within the acceleration limit, which
/// may take it beyond the target. Under a jerk limit, the position is an average of what the planner without it does; that
/// pauses between acceleration and deceleration for as long as the average looks back, so that the average never has both.
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
    /// Position and velocity before the average.
    x: f64,
    v: f64,
    /// Cycles since the velocity before the average last rose, and since it last fell.
    since: [usize; 2],
    smooth: Smooth,
}

impl SimpleTp {
    /// Planner that can limit jerk.
    pub(crate) fn smooth() -> Self {
        Self { smooth: Smooth::new(), ..Self::default() }
    }

    /// Stops at a position and switches the planner off.
    pub(crate) fn reset(&mut self, pos: f64) {
        self.smooth.reset();
        (self.pos, self.target, self.x) = (pos, pos, pos);
        (self.vel, self.v) = (0.0, 0.0);
        self.enable = false;
        self.active = false;
    }

    /// Sets the position to a value, in motion or at rest; the target keeps its distance.
    pub(crate) fn shift(&mut self, by: f64) {
        self.pos += by;
        self.x += by;
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
        let has_jerk = 0.0 < self.max_jerk && self.max_jerk < f64::INFINITY;
        if !has_jerk && self.is_off() {
            self.active = false;
            return;
        }
        if self.smooth.is_flat() {
            let samples = if has_jerk { self.max_acc / (self.max_jerk * dt) } else { 0.0 };
            // An acceleration that may change its sign in a cycle needs no average.
            self.since = [usize::MAX; 2];
            self.smooth.choose(if samples <= 0.5 { 0.0 } else { ceil(samples.max(2.0)) });
        }
        if self.smooth.is_off() {
            (self.x, self.v) = (self.pos, self.vel);
        }
        let mut acc = self.max_acc;
        if has_jerk && !self.smooth.is_off() {
            let most = self.max_jerk * self.smooth.samples() as f64 * dt;
            acc = if most < acc { most } else { acc };
        }
        let from = self.x;
        if exactly || has_jerk {
            self.walk_exactly(acc, dt);
        } else {
            self.walk(acc, dt);
        }
        if self.smooth.is_off() {
            (self.pos, self.vel) = (self.x, self.v);
            return;
        }
        let mean = self.smooth.pass(self.x - from);
        if self.smooth.is_flat() {
            (self.pos, self.vel) = (self.x, 0.0);
        } else {
            self.pos += mean;
            self.vel = mean / dt;
            self.active = true;
        }
    }

    /// Returns the distance from its target at which the planner may come to rest.
    pub(crate) fn deadband(&self, dt: f64) -> f64 {
        tiny(self.max_acc * dt, dt)
    }

    /// Returns whether a cycle without a jerk limit would leave everything as it is: at rest, at the very target.
    fn is_off(&self) -> bool {
        let at = self.pos.to_bits();
        let is_there = at == self.target.to_bits() && at == self.x.to_bits();
        // A cycle adds zero, which changes the negative one.
        let is_still =
            (self.v.to_bits() | self.vel.to_bits()) == 0 && (self.pos + 0.0).to_bits() == at;
        is_there && is_still && self.smooth.is_off()
    }

    /// Moves for a cycle, without the jerk limit.
    fn walk(&mut self, acc: f64, dt: f64) {
        let max_dv = acc * dt;
        let mut want = 0.0;
        self.active = false;
        if self.enable {
            let error = self.target - self.x;
            if fabs(error) > tiny(max_dv, dt) {
                self.active = true;
                let speed = sqrt(2.0 * acc * fabs(error) + max_dv * max_dv) - max_dv;
                let speed = less(speed, self.max_vel);
                let sign = if error > 0.0 { 1.0 } else { -1.0 };
                let now = self.v * sign;
                // It accelerates only to a speed from which it can pause before it brakes.
                let calm = less(speed, self.calm_speed(fabs(error), acc, dt));
                want = sign
                    * if speed < now {
                        speed
                    } else if now < calm {
                        calm
                    } else {
                        now
                    };
            }
        } else {
            self.target = self.x;
        }
        let before = self.v;
        if want > self.v + max_dv {
            self.v += max_dv;
        } else if want < self.v - max_dv {
            self.v -= max_dv;
        } else {
            self.v = want;
        }
        self.pause(before);
        if self.v != 0.0 {
            self.active = true;
        }
        self.x += self.v * dt;
        if !self.enable {
            self.target = self.x;
        }
    }

    /// Returns the highest speed from which the planner can pause and then brake within a distance.
    fn calm_speed(&self, distance: f64, acc: f64, dt: f64) -> f64 {
        if self.smooth.is_off() {
            return f64::INFINITY;
        }
        let pause = (self.smooth.samples() + 2) as f64 * dt;
        let speed = acc * (sqrt(pause * pause + 2.0 * distance / acc) - pause);
        if speed > 0.0 { speed } else { 0.0 }
    }

    /// Keeps the velocity of the last cycle while the average still has the opposite acceleration.
    fn pause(&mut self, before: f64) {
        let samples = if self.smooth.is_off() { 0 } else { self.smooth.samples() };
        let [up, down] = self.since;
        if self.v > before && down < samples || self.v < before && up < samples {
            self.v = before;
        }
        self.count(before);
    }

    /// Counts the cycles since the velocity rose and fell.
    fn count(&mut self, before: f64) {
        let [up, down] = &mut self.since;
        *up = if self.v > before { 0 } else { up.saturating_add(1) };
        *down = if self.v < before { 0 } else { down.saturating_add(1) };
    }

    /// Moves for a cycle, without the jerk limit; near the target, exactly there.
    fn walk_exactly(&mut self, acc: f64, dt: f64) {
        let max_dv = acc * dt;
        let error = self.target - self.x;
        let last = error / dt;
        if self.enable
            && fabs(error) <= tiny(max_dv, dt)
            && fabs(last - self.v) <= max_dv
            && fabs(last) <= self.max_vel
        {
            let before = core::mem::replace(&mut self.v, last);
            self.count(before);
            self.x = self.target;
            self.active = last != 0.0;
        } else {
            self.walk(acc, dt);
        }
    }

    /// Reduces the motion of the last cycle, which began at `from`, to a part; reduces the velocity to the same part.
    pub(crate) fn slow_down(&mut self, from: f64, factor: f64) {
        self.pos = from + (self.pos - from) * factor;
        self.vel *= factor;
        self.v *= factor;
        self.x = self.pos;
        if !self.smooth.is_off() {
            self.x += self.smooth.slow_down(factor);
        }
        if !self.enable {
            self.target = self.x;
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
            let mut one = SimpleTp { max_jerk: jerk, ..SimpleTp::smooth() };
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
            assert!(top <= 1350.0 * 1.0001 && worst > 0.9 * jerk.min(0.7e6), "{top} {worst}");
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

//! Realtime. Planner of one coordinate that moves to a target, within a velocity and an acceleration limit.

use libm::{fabs, sqrt};

/// The planner. Its limits and target may change in motion: it brakes and reverses within the acceleration limit, which
/// may take it beyond the target.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SimpleTp {
    /// Target; equals the position while the planner is switched off.
    pub(crate) target: f64,
    /// Velocity limit, not negative.
    pub(crate) max_vel: f64,
    /// Acceleration limit, not negative.
    pub(crate) max_acc: f64,
    /// FALSE brakes to a stop.
    pub(crate) enable: bool,
    /// Current position.
    pub(crate) pos: f64,
    /// Current velocity.
    pub(crate) vel: f64,
    /// True while moving, or away from the target.
    pub(crate) active: bool,
}

impl SimpleTp {
    /// Stops at a position and switches the planner off.
    pub(crate) const fn reset(&mut self, pos: f64) {
        self.pos = pos;
        self.target = pos;
        self.vel = 0.0;
        self.enable = false;
        self.active = false;
    }

    /// Runs one cycle. Stops within a deadband of 0.001·a·dt² of the target.
    pub(crate) fn step(&mut self, dt: f64) {
        let max_dv = self.max_acc * dt;
        let mut want = 0.0;
        self.active = false;
        if self.enable {
            let error = self.target - self.pos;
            if fabs(error) > tiny(max_dv, dt) {
                self.active = true;
                let speed = sqrt(2.0 * self.max_acc * fabs(error) + max_dv * max_dv) - max_dv;
                let speed = if speed < self.max_vel { speed } else { self.max_vel };
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

    /// Reduces the motion of the last cycle, which began at `from`, to a part; reduces the velocity to the same part.
    pub(crate) fn slow_down(&mut self, from: f64, factor: f64) {
        self.pos = from + (self.pos - from) * factor;
        self.vel *= factor;
        if !self.enable {
            self.target = self.pos;
        }
    }

    /// Runs one cycle; near the target, it ends exactly there instead of within the deadband.
    pub(crate) fn step_exactly(&mut self, dt: f64) {
        let max_dv = self.max_acc * dt;
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
            self.step(dt);
        }
    }
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
            let before = *tp;
            step(tp, DT);
            assert!(fabs(tp.vel) <= tp.max_vel * (1.0 + 1e-12));
            assert!(fabs(tp.vel - before.vel) <= tp.max_acc * DT * (1.0 + 1e-12));
            assert!(fabs(tp.pos - before.pos - tp.vel * DT) < 1e-12);
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

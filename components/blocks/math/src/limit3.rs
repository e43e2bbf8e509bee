//! `limit3`.
use crate::bounds::{larger, smaller};
use hal_component::{Component, In, Out, Period, Update};

#[cfg(test)]
mod closed;

/// Distances and speeds with a smaller difference count as equal.
const NEAR: f64 = 1e-9;

/// Limits position, velocity and acceleration.
///
/// The output follows the input as fast as `maxv` and `maxa` allow, meets a moving input with the input's speed, and
/// stops at `min` and `max` without passing them.
///
/// A move over a distance d from rest takes 2·√(d/`maxa`), or d/`maxv` + `maxv`/`maxa` if the speed is reached. With
/// the period T, the output may overshoot a target by `maxa`·T²/8, and the last 4·`maxa`·T² may take longer, in a
/// sawtooth that a larger `smooth-steps` removes.
///
/// # Example
///
/// ```hal
/// # Half a second to speed, and half a second to a stop.
/// loadrt limit3
/// loadrt threads name1=servo period1=1000000
/// addf limit3.0 servo
/// start
/// setp limit3.0.maxv 10
/// setp limit3.0.maxa 20
/// setp limit3.0.max 100
/// setp limit3.0.in 5
/// run 250ms
/// getp limit3.0.out # -> 0.6275
/// run 2s
/// getp limit3.0.out # -> 5
/// ```
#[derive(Component)]
pub(crate) struct Limit3 {
    /// Position to follow, in units.
    in_: In<f64>,
    /// While false, the input counts as zero; the output moves there within its limits.
    #[hal(default = true)]
    enable: In<bool>,
    /// While true, the output jumps to the input (within `min` and `max`) at once. Hold it for two cycles: after only
    /// one, the jump counts as speed, and the output has to brake.
    load: In<bool>,
    /// Minimum of the position, in units.
    #[hal(default = -1e20)]
    min_: In<f64>,
    /// Maximum of the position, in units.
    #[hal(default = 1e20)]
    max_: In<f64>,
    /// Maximum speed, in units per second; positive.
    #[hal(default = 1e20)]
    maxv: In<f64>,
    /// Maximum acceleration, in units per second²; positive.
    #[hal(default = 1e7)]
    maxa: In<f64>,
    /// Number of cycles over which the last bit of speed may be removed on arrival, which avoids a sawtooth at rest.
    #[hal(default = 2)]
    smooth_steps: In<u32>,
    /// Limited position, in units.
    out: Out<f64>,
    #[state]
    in_old: f64,
    #[state]
    out_old: f64,
}

impl Update for Limit3 {
    fn update(&mut self, period: Period) {
        let input = if self.enable.get() { self.in_.get() } else { 0.0 };
        let out = self.out.get();
        let next = if self.load.get() {
            capped(input, self.min_.get(), self.max_.get())
        } else {
            self.step(input, out, period.secs())
        };
        // A position loaded within the limits counts as the input.
        self.in_old = if self.load.get() { next } else { input };
        self.out_old = out;
        self.out.set(next);
    }
}

/// Target of the output, and the positions that the output can reach.
struct Goal {
    /// Position of the target when the output, at maximum braking, has reached its speed.
    at_min: f64,
    /// Position of the target when the output, at maximum acceleration, has reached its speed.
    at_max: f64,
    now: f64,
    before: f64,
    /// Speed of the output relative to the target.
    faster: f64,
    /// Lowest position where the output can reach the target's speed.
    reach_min: f64,
    /// Highest position where the output can reach the target's speed.
    reach_max: f64,
}

impl Limit3 {
    fn step(&self, input: f64, out: f64, dt: f64) -> f64 {
        let (min, max) = (self.min_.get(), self.max_.get());
        let (maxv, maxa) = (self.maxv.get(), self.maxa.get());
        let in_vel = (input - self.in_old) / dt;
        let out_vel = (out - self.out_old) / dt;
        // Range of speed and position after one period.
        let min_vel = larger(out_vel - maxa * dt, -maxv);
        let max_vel = smaller(out_vel + maxa * dt, maxv);
        let min_pos = out + min_vel * dt;
        let max_pos = out + max_vel * dt;
        let one = |pos: f64| min_pos <= pos && pos <= max_pos;
        // Position of rest after such a period.
        let stop = |vel: f64| out + vel / 2.0 * (vel.abs() / maxa + dt);
        let (stop_min, stop_max) = (stop(min_vel), stop(max_vel));
        // Time and position at which the output would reach the input's speed after such a period.
        let min_time = (in_vel - min_vel).abs() / maxa - dt;
        let max_time = (in_vel - max_vel).abs() / maxa - dt;
        let meet_min = min_pos + (min_vel + in_vel) / 2.0 * min_time;
        let meet_max = max_pos + (max_vel + in_vel) / 2.0 * max_time;
        let in_min = input + in_vel * min_time;
        let in_max = input + in_vel * max_time;

        let limit = if stop_max > max + NEAR && !one(max) {
            Some(max)
        } else if stop_min < min - NEAR && !one(min) {
            Some(min)
        } else if input >= max && in_max > meet_max {
            Some(max)
        } else if input <= min && in_min < meet_min {
            Some(min)
        } else {
            None
        };
        let goal = match limit {
            Some(limit) => Goal {
                at_min: limit,
                at_max: limit,
                now: limit,
                before: limit,
                faster: -out_vel,
                reach_min: stop_min,
                reach_max: stop_max,
            },
            None => Goal {
                at_min: in_min,
                at_max: in_max,
                now: input,
                before: self.in_old,
                faster: out_vel - in_vel,
                reach_min: meet_min,
                reach_max: meet_max,
            },
        };
        self.toward(&goal, out, out_vel, (min_pos, max_pos), dt)
    }

    /// Returns the next position toward a target.
    fn toward(
        &self,
        goal: &Goal,
        out: f64,
        out_vel: f64,
        (min_pos, max_pos): (f64, f64),
        dt: f64,
    ) -> f64 {
        // Time to arrive with the target's speed, at constant acceleration.
        let time =
            if goal.faster.abs() < NEAR { 0.0 } else { 2.0 * (out - goal.before) / goal.faster };
        if min_pos <= goal.now && goal.now <= max_pos && time.abs() <= dt {
            goal.now
        } else if goal.reach_max < goal.at_max + NEAR {
            max_pos
        } else if goal.reach_min > goal.at_min - NEAR {
            min_pos
        } else if time.abs() < dt * f64::from(self.smooth_steps.get()) {
            let sign = if time < 0.0 { -1.0 } else { 1.0 };
            let whole = libm::trunc((time - NEAR * sign) / dt + sign) * dt;
            let accel = goal.faster / whole;
            capped(out + (out_vel + accel * dt) * dt, min_pos, max_pos)
        } else if goal.at_max + NEAR < goal.reach_max && goal.before > out {
            min_pos
        } else if goal.at_min - NEAR > goal.reach_min && goal.before < out {
            max_pos
        } else {
            f64::midpoint(min_pos, max_pos)
        }
    }
}

/// Limits a number; the maximum wins if the bounds are crossed.
fn capped(x: f64, min: f64, max: f64) -> f64 {
    smaller(larger(x, min), max)
}

#[cfg(test)]
mod tests {
    use super::Limit3;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Limit3>(include_str!("../traces/limit3.txt")), 3246);
    }
}

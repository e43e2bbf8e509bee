//! Limits of several axes or joints, and the arithmetic of the conditions over all of them.
//!
//! The loops have neither branches nor calls, so that they become vector instructions: each finds one value per row, and
//! the least or largest of them afterwards.

use super::Allowed;
use crate::machine::Limits;

/// Bounds of the first three derivatives, of each row.
type Bounds<'a, const N: usize> = [&'a [f64; N]; 3];

/// Limits of axes or joints.
#[derive(Clone, Debug)]
pub(super) struct Rows<const N: usize> {
    pub(super) limits: [Limits; N],
    acceleration: [f64; N],
    jerk: [f64; N],
    /// Reciprocals of the limits.
    per_velocity: [f64; N],
    per_acceleration: [f64; N],
    per_jerk: [f64; N],
}

impl<const N: usize> Rows<N> {
    pub(super) fn new(limits: [Limits; N]) -> Self {
        Self {
            limits,
            acceleration: limits.map(|l| l.acceleration),
            jerk: limits.map(|l| l.jerk),
            per_velocity: limits.map(|l| 1.0 / l.velocity),
            per_acceleration: limits.map(|l| 1.0 / l.acceleration),
            per_jerk: limits.map(|l| 1.0 / l.jerk),
        }
    }

    /// Returns the largest shares of velocity, acceleration and jerk that are used at a speed of 1 along the path.
    pub(super) fn shares(&self, [a1, a2, a3]: Bounds<'_, N>) -> [f64; 3] {
        let largest = |bounds: &[f64; N], per: &[f64; N]| {
            let mut each = *bounds;
            each.iter_mut().zip(per).for_each(|(x, per)| *x *= per);
            each.into_iter().fold(0.0, |m, x| if x > m { x } else { m })
        };
        [
            largest(a1, &self.per_velocity),
            largest(a2, &self.per_acceleration),
            largest(a3, &self.per_jerk),
        ]
    }

    /// Returns the largest accelerations along the path at rest and at `speed` that keep the limits of acceleration.
    pub(super) fn accelerations(&self, [a1, a2, _]: Bounds<'_, N>, speed: f64) -> [f64; 2] {
        let square = speed * speed;
        let (mut rest, mut at_speed) = (*a1, *a1);
        for ((rest, a1), l) in rest.iter_mut().zip(a1).zip(&self.acceleration) {
            *rest = only(*a1 > 0.0, l / a1);
        }
        for (((at_speed, a1), a2), l) in at_speed.iter_mut().zip(a1).zip(a2).zip(&self.acceleration)
        {
            *at_speed = only(*a1 > 0.0, (l - a2 * square) / a1);
        }
        [least(&rest), least(&at_speed)]
    }

    /// Returns the largest acceleration along the path at `speed` that keeps the limits of jerk, with a filter of `time`.
    pub(super) fn at_speed(&self, [a1, a2, a3]: Bounds<'_, N>, speed: f64, time: f64) -> f64 {
        let square = speed * speed;
        let mut each = *a1;
        for ((((x, a1), a2), a3), l) in each.iter_mut().zip(a1).zip(a2).zip(a3).zip(&self.jerk) {
            let weight = 3.0 * a2 * speed + a1 / time;
            *x = only(weight > 0.0, (l - a3 * square * speed) / weight);
        }
        least(&each)
    }

    /// Returns the largest acceleration at rest with which `top` at full speed keeps the limits of jerk.
    ///
    /// Acceleration falls from it to `top` with v², so 3·A2·v·a is a cubic in v. Its Bernstein coefficients are largest at
    /// full speed, or at two thirds of 3·A2·v·rest.
    pub(super) fn at_rest(
        &self,
        [a1, a2, a3]: Bounds<'_, N>,
        speed: f64,
        top: f64,
        time: f64,
    ) -> f64 {
        let square = speed * speed;
        let mut each = *a1;
        for ((((x, a1), a2), a3), l) in each.iter_mut().zip(a1).zip(a2).zip(a3).zip(&self.jerk) {
            let turning = 3.0 * a2 * speed;
            let left = (l - a3 * square * speed - turning * top) * time;
            let low = a1 * top;
            let one = only(*a1 > 0.0, (if left > low { left } else { low }) / a1);
            let weight = turning * (2.0 / 3.0) + a1 / time;
            let two = only(weight > 0.0, l / weight);
            *x = if one < two { one } else { two };
        }
        least(&each)
    }

    /// Returns true if every speed and acceleration of `allowed` keeps the limits, by the three conditions themselves.
    pub(super) fn hold(&self, [a1, a2, a3]: Bounds<'_, N>, allowed: &Allowed, time: f64) -> bool {
        let slack = 1.0 + 1e-12;
        let (v, a, top) = (allowed.speed, allowed.rest, allowed.top());
        let per_time = a / time;
        let rows = self.limits.iter().zip(a1).zip(a2).zip(a3);
        let moving = rows.filter(|(((_, a1), a2), a3)| **a1 != 0.0 || **a2 != 0.0 || **a3 != 0.0);
        moving.into_iter().all(|(((l, a1), a2), a3)| {
            // The sum of the shares of acceleration is linear in v², so rest and full speed suffice.
            let below = a1 * v <= l.velocity * slack
                && a1 * a <= l.acceleration * slack
                && a2 * v * v + a1 * top <= l.acceleration * slack;
            // The jerk at the share x of full speed is cubic·x³ + linear·x + a1·a/time.
            let linear = 3.0 * a2 * v * a;
            let cubic = a3 * v * v * v - 3.0 * a2 * v * (a - top);
            let inside = -3.0 * cubic > linear;
            let peak = if inside {
                2.0 / 3.0 * linear * (linear / (-3.0 * cubic)).sqrt()
            } else {
                cubic + linear
            };
            below && (!l.jerk.is_finite() || peak + a1 * per_time <= l.jerk * slack)
        })
    }
}

/// Returns the value, or infinity where the condition is false.
#[inline(always)]
const fn only(condition: bool, value: f64) -> f64 {
    if condition { value } else { f64::INFINITY }
}

/// Returns the least value.
fn least<const N: usize>(values: &[f64; N]) -> f64 {
    values.iter().fold(f64::INFINITY, |m, x| if *x < m { *x } else { m })
}

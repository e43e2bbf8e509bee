//! Highest speed and acceleration along a cell of the path, from bounds of its derivatives.
//!
//! With v, a and k the speed, acceleration and jerk along the path, an axis moves with
//!
//! - velocity q′v, acceleration q″v² + q′a, jerk q‴v³ + 3q″va + q′k.
//!
//! With A1, A2, A3 the bounds of |q′|, |q″|, |q‴| in the cell, and a jerk filter of length T behind a follower that
//! cruises for T between acceleration and deceleration (|k| ≤ a/T), these conditions keep the limits V, A and J:
//!
//! - A1·v ≤ V,
//! - A2·v² + A1·a ≤ A,
//! - A3·v³ + 3·A2·v·a + A1·r/T ≤ J, with r the acceleration at rest.
//!
//! The acceleration of a cell falls with the squared speed, from r at rest to its least value at full speed. The pairs of speed and
//! acceleration that it allows are a convex set, so the means that the filter makes of them belong to it too.

use crate::{
    bounds::Bounds,
    machine::{JOINTS, Limits, Machine},
    pose::AXES,
};

/// Shares of the limits that stay unused, so that rounding is no violation.
const RESERVE: [f64; 3] = [1.0 - 1e-9, 1.0 - 1e-8, 1.0 - 1e-6];

/// Shares of acceleration and jerk that the curvature of a cell may use when there is a jerk filter. Motion along the path
/// has the rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    acceleration: f64,
    jerk: f64,
}

impl Shares {
    /// For moves. They are long enough that acceleration along them counts too.
    pub(crate) const MOVE: Self = Self { acceleration: 0.9, jerk: 0.5 };
    /// For blends, which are passed at one speed.
    pub(crate) const BLEND: Self = Self { acceleration: 0.9, jerk: 0.78 };
    /// Everything, without a filter.
    const ALL: Self = Self { acceleration: 1.0, jerk: 1.0 };
}

/// Bounds of the derivatives of the joints in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointBounds {
    pub(crate) first: [f64; JOINTS],
    pub(crate) second: [f64; JOINTS],
    pub(crate) third: [f64; JOINTS],
}

/// Highest speed in a cell, and the acceleration along the path: `rest - fade·v²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Allowed {
    pub(crate) speed: f64,
    pub(crate) rest: f64,
    pub(crate) fade: f64,
}

impl Allowed {
    /// Limits with this acceleration at rest, and that one at full speed.
    pub(crate) fn between(speed: f64, rest: f64, top: f64) -> Self {
        let fade = (rest - top) / (speed * speed);
        if fade > 0.0 && fade < f64::INFINITY {
            Self { speed, rest, fade }
        } else {
            Self { speed, rest: rest.min(top), fade: 0.0 }
        }
    }

    /// Returns the acceleration at this speed.
    pub(crate) fn at(&self, speed: f64) -> f64 {
        (self.rest - self.fade * speed * speed).max(0.0)
    }

    /// Returns the acceleration at full speed.
    pub(crate) fn top(&self) -> f64 {
        self.at(self.speed)
    }
}

/// The rule that turns bounds into speed and acceleration.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    axes: [Limits; AXES],
    joints: [Limits; JOINTS],
    /// Reciprocals of the limits.
    per_axis: [Limits; AXES],
    per_joint: [Limits; JOINTS],
    top: f64,
    jerk: bool,
    period: f64,
    /// Servo periods that the jerk filter averages; 1 without a limit of jerk.
    pub(crate) samples: u16,
}

/// Longest filter, in servo periods.
pub(crate) const MAX_SAMPLES: u16 = 2000;

impl Law {
    /// Rule for a machine; `axes` are its axis limits with the limits of directly mapped joints folded in.
    pub(crate) fn new(machine: &Machine, axes: [Limits; AXES]) -> Self {
        let reserved = |l: Limits| Limits {
            velocity: l.velocity * RESERVE[0],
            acceleration: l.acceleration * RESERVE[1],
            jerk: l.jerk * RESERVE[2],
        };
        let jerk = axes.iter().chain(&machine.joints).any(|l| l.jerk.is_finite());
        let (axes, joints) = (axes.map(reserved), machine.joints.map(reserved));
        let inverse = |l: Limits| Limits {
            velocity: 1.0 / l.velocity,
            acceleration: 1.0 / l.acceleration,
            jerk: 1.0 / l.jerk,
        };
        Self {
            axes,
            joints,
            per_axis: axes.map(inverse),
            per_joint: joints.map(inverse),
            top: machine.top_speed(),
            jerk,
            period: machine.period,
            samples: 1,
        }
    }

    /// Returns true if any axis or joint has a jerk limit.
    pub(crate) const fn has_jerk(&self) -> bool {
        self.jerk
    }

    /// Returns the length of the filter in seconds.
    pub(crate) fn time(&self) -> f64 {
        f64::from(self.samples) * self.period
    }

    /// Returns the time by which the limits of a cell reach beyond it, at its speed: the length of the filter and of the
    /// third difference.
    pub(crate) fn reach(&self) -> f64 {
        if self.jerk { self.time() + 3.0 * self.period } else { 0.0 }
    }

    /// Longest possible reach along the path.
    pub(crate) fn longest_reach(&self) -> f64 {
        self.top * self.reach() * (1.0 + 1e-6)
    }

    /// Chooses the length of the filter for a run that begins with this feed. Call it only where the motion rests.
    pub(crate) fn choose_filter(&mut self, feed: f64) {
        let mut time: f64 = 0.0;
        for l in self.axes.iter().chain(&self.joints) {
            if l.jerk.is_finite() && l.acceleration.is_finite() {
                let speed = l.velocity.min(feed).min(self.top);
                time = time.max((l.acceleration / l.jerk).min((speed / l.jerk).sqrt()));
            }
        }
        if !self.jerk {
            self.samples = 1;
            return;
        }
        let samples = (time / self.period - 1e-9).ceil();
        self.samples = if samples < f64::from(MAX_SAMPLES) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "2 to 2000"
            )]
            let whole = samples.max(2.0) as u16;
            whole
        } else {
            MAX_SAMPLES
        };
    }

    /// Returns what a cell allows; `feed` is the highest path speed that the feed permits.
    pub(crate) fn allowed(
        &self,
        bounds: &Bounds,
        joints: Option<&JointBounds>,
        feed: f64,
        shares: Shares,
    ) -> Allowed {
        let (first, second, third) = (&bounds.first.0, &bounds.second.0, &bounds.third.0);
        let (mut r1, mut r2, mut r3) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut widen = |(l, a1, a2, a3): (&Limits, f64, f64, f64)| {
            r1 = r1.max(a1 * l.velocity);
            r2 = r2.max(a2 * l.acceleration);
            r3 = r3.max(a3 * l.jerk);
        };
        rows(&self.per_axis, first, second, third).for_each(&mut widen);
        if let Some(j) = joints {
            rows(&self.per_joint, &j.first, &j.second, &j.third).for_each(&mut widen);
        }
        let mut speed = feed.min(self.top);
        if r1 * speed > 1.0 {
            speed = 1.0 / r1;
        }
        let shares = if self.jerk { shares } else { Shares::ALL };
        if r2 * speed * speed > shares.acceleration {
            speed = (shares.acceleration / r2).sqrt();
        }
        if self.jerk && r3 * speed * speed * speed > shares.jerk {
            speed = libm::cbrt(shares.jerk / r3) * (1.0 - 1e-12);
        }
        let square = speed * speed;
        let (mut rest, mut at_speed) = (f64::INFINITY, f64::INFINITY);
        let time = self.time();
        let mut narrow = |(l, a1, a2, a3): (&Limits, f64, f64, f64)| {
            if a1 > 0.0 {
                rest = rest.min(l.acceleration / a1);
                at_speed = at_speed.min((l.acceleration - a2 * square) / a1);
            }
            if self.jerk && l.jerk.is_finite() {
                let weight = 3.0 * a2 * speed + a1 / time;
                if weight > 0.0 {
                    at_speed = at_speed.min((l.jerk - a3 * square * speed) / weight);
                }
            }
        };
        rows(&self.axes, first, second, third).for_each(&mut narrow);
        if let Some(j) = joints {
            rows(&self.joints, &j.first, &j.second, &j.third).for_each(&mut narrow);
        }
        let top = if at_speed > 0.0 { at_speed.min(1e9) } else { 0.0 };
        let mut rest = rest.min(1e9);
        if self.jerk {
            // Acceleration falls from `rest` to `top` with v², so 3·A2·v·a is a cubic in v. Its Bernstein coefficients are
            // largest at full speed, or at two thirds of 3·A2·v·rest.
            let mut narrow = |(l, a1, a2, a3): (&Limits, f64, f64, f64)| {
                if l.jerk.is_finite() {
                    let turning = 3.0 * a2 * speed;
                    let left = l.jerk - a3 * square * speed - turning * top;
                    rest = rest.min((left * time).max(a1 * top) / a1);
                    rest = rest.min(l.jerk / (turning * (2.0 / 3.0) + a1 / time));
                }
            };
            rows(&self.axes, first, second, third).for_each(&mut narrow);
            if let Some(j) = joints {
                rows(&self.joints, &j.first, &j.second, &j.third).for_each(&mut narrow);
            }
        }
        Allowed::between(speed, rest.max(top), top)
    }

    /// Returns true if every speed and acceleration of these limits keeps the limits of the machine, by the three
    /// conditions themselves.
    pub(crate) fn holds(
        &self,
        bounds: &Bounds,
        joints: Option<&JointBounds>,
        allowed: &Allowed,
    ) -> bool {
        let time = self.time();
        let (v, a, top) = (allowed.speed, allowed.rest, allowed.top());
        let good = |(l, a1, a2, a3): (&Limits, f64, f64, f64)| {
            let slack = 1.0 + 1e-12;
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
            below && (!l.jerk.is_finite() || peak + a1 * a / time <= l.jerk * slack)
        };
        rows(&self.axes, &bounds.first.0, &bounds.second.0, &bounds.third.0).all(good)
            && joints.is_none_or(|j| rows(&self.joints, &j.first, &j.second, &j.third).all(good))
    }

    /// Returns the joint that limits the speed most.
    pub(crate) fn tightest_joint(&self, j: &JointBounds) -> usize {
        let speed = |(l, a1, a2, _): (&Limits, f64, f64, f64)| {
            (a1 / l.velocity).max((a2 / l.acceleration).sqrt())
        };
        let ratios = rows(&self.joints, &j.first, &j.second, &j.third).map(speed).enumerate();
        ratios.fold((0, 0.0), |m, (k, r)| if r > m.1 { (k, r) } else { m }).0
    }
}

/// Limits with the bounds of the three derivatives, of axes or joints that move.
fn rows<'a>(
    limits: &'a [Limits],
    first: &'a [f64],
    second: &'a [f64],
    third: &'a [f64],
) -> impl Iterator<Item = (&'a Limits, f64, f64, f64)> + Clone {
    let bounds = first.iter().zip(second).zip(third);
    let rows = limits.iter().zip(bounds).map(|(l, ((a, b), c))| (l, *a, *b, *c));
    rows.filter(|(_, a, b, c)| *a != 0.0 || *b != 0.0 || *c != 0.0)
}

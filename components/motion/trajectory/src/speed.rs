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
    pose::{AXES, Group, Pose},
};

mod rows;
mod stretch;

use rows::Rows;
pub(crate) use stretch::Stretch;

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

impl JointBounds {
    const fn rows(&self) -> [&[f64; JOINTS]; 3] {
        [&self.first, &self.second, &self.third]
    }
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
    axes: Rows<AXES>,
    xyz: Rows<3>,
    joints: Rows<JOINTS>,
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
        let [x, y, z, ..] = axes;
        let jerk = axes.iter().chain(&machine.joints).any(|l| l.jerk.is_finite());
        Self {
            axes: Rows::new(axes.map(reserved)),
            xyz: Rows::new([x, y, z].map(reserved)),
            joints: Rows::new(machine.joints.map(reserved)),
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
        for l in self.axes.limits.iter().chain(&self.joints.limits) {
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
        let along = bounds.rows();
        match along.map(|row| row.split_first_chunk()) {
            // Most programs move three axes only.
            [Some((a, x)), Some((b, y)), Some((c, z))]
                if [x, y, z].iter().all(|rest| rest.iter().all(|r| *r == 0.0)) =>
            {
                self.allowed_by(&self.xyz, [a, b, c], joints, feed, shares)
            }
            _ => self.allowed_by(&self.axes, along, joints, feed, shares),
        }
    }

    fn allowed_by<const N: usize>(
        &self,
        axes: &Rows<N>,
        along: [&[f64; N]; 3],
        joints: Option<&JointBounds>,
        feed: f64,
        shares: Shares,
    ) -> Allowed {
        let turning = joints.map(JointBounds::rows);
        let [mut r1, mut r2, mut r3] = axes.shares(along);
        if let Some(j) = turning {
            let [s1, s2, s3] = self.joints.shares(j);
            (r1, r2, r3) = (r1.max(s1), r2.max(s2), r3.max(s3));
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
        let time = self.time();
        let [mut rest, mut at_speed] = axes.accelerations(along, speed);
        if let Some(j) = turning {
            let [a, b] = self.joints.accelerations(j, speed);
            (rest, at_speed) = (rest.min(a), at_speed.min(b));
        }
        if self.jerk {
            at_speed = at_speed.min(axes.at_speed(along, speed, time));
            if let Some(j) = turning {
                at_speed = at_speed.min(self.joints.at_speed(j, speed, time));
            }
        }
        let top = if at_speed > 0.0 { at_speed.min(1e9) } else { 0.0 };
        let mut rest = rest.min(1e9);
        if self.jerk {
            rest = rest.min(axes.at_rest(along, speed, top, time));
            if let Some(j) = turning {
                rest = rest.min(self.joints.at_rest(j, speed, top, time));
            }
        }
        Allowed::between(speed, rest.max(top), top)
    }

    /// Returns how much longer a blend would have to be to carry a speed.
    pub(crate) fn stretch(
        &self,
        bounds: &Bounds,
        joints: Option<&JointBounds>,
        speed: f64,
        shares: Shares,
    ) -> Stretch {
        let [_, mut r2, mut r3] = self.axes.shares(bounds.rows());
        if let Some(j) = joints {
            let [_, s2, s3] = self.joints.shares(j.rows());
            (r2, r3) = (r2.max(s2), r3.max(s3));
        }
        self.stretch_of(r2, r3, speed, shares)
    }

    fn stretch_of(&self, r2: f64, r3: f64, speed: f64, shares: Shares) -> Stretch {
        let shares = if self.jerk { shares } else { Shares::ALL };
        let square = speed * speed;
        let acceleration = r2 * square / shares.acceleration;
        let jerk = if self.jerk { (r3 * square * speed / shares.jerk).sqrt() } else { 0.0 };
        Stretch { acceleration, jerk }
    }

    /// Returns the half of a blend between two lines that carries a speed, for acceleration and for jerk. `turn` is the
    /// difference of their directions, `most` the highest acceleration along the path. The second derivative of such a
    /// blend is at most 3/4 of `turn` per half, the third 3/2 of it per squared half.
    pub(crate) fn half(&self, turn: &Pose, speed: f64, most: f64) -> Stretch {
        let second = *turn * 0.75;
        let bounds =
            Bounds { second: second.abs(), third: (*turn * 1.5).abs(), ..Bounds::default() };
        let all = self.stretch(&bounds, None, speed, Shares::BLEND);
        let bend = Group::ALL.map(|g| second.norm(g)).into_iter().fold(0.0, f64::max);
        let along = self.bend_share(bend, most, Shares::BLEND) * speed * speed;
        all.max(Stretch { acceleration: along, jerk: 0.0 })
    }

    /// Returns the lowest acceleration of the axes that `turn` moves.
    pub(crate) fn acceleration(&self, turn: &Pose) -> f64 {
        let rows = turn.0.iter().zip(&self.axes.limits).filter(|(by, _)| by.abs() > 1e-9);
        rows.map(|(_, l)| l.acceleration).fold(1e9, f64::min)
    }

    /// Returns the share of the acceleration along the path that the curvature `bend` may use takes at a speed of 1.
    pub(crate) fn bend_share(&self, bend: f64, most: f64, shares: Shares) -> f64 {
        let shares = if self.jerk { shares } else { Shares::ALL };
        bend / (shares.acceleration * most)
    }

    /// Returns limits that keep the acceleration of the path too: what the curvature `bend` and the motion along it need
    /// together is at most `most`. On an arc they are at right angles; elsewhere their amounts are added.
    pub(crate) fn along(
        &self,
        allowed: &Allowed,
        bend: f64,
        is_arc: bool,
        most: f64,
        shares: Shares,
    ) -> Allowed {
        if most >= 1e9 {
            return *allowed;
        }
        let mut speed = allowed.speed;
        let share = self.bend_share(bend, most, shares);
        if share * speed * speed > 1.0 {
            speed = (1.0 / share).sqrt();
        }
        let turns = bend * speed * speed;
        let left = (most - turns).max(0.0);
        let left = if is_arc { (left * (most + turns)).sqrt() } else { left };
        let top = allowed.at(speed).min(left);
        Allowed::between(speed, allowed.rest.min(most).max(top), top)
    }

    /// Returns the highest speed along a cell that the limits of velocity alone allow.
    pub(crate) fn fastest(&self, bounds: &Bounds, joints: Option<&JointBounds>) -> f64 {
        let [mut share, ..] = self.axes.shares(bounds.rows());
        if let Some(j) = joints {
            share = share.max(self.joints.shares(j.rows())[0]);
        }
        self.top.min(1.0 / share)
    }

    /// Returns true if every speed and acceleration of these limits keeps the limits of the machine, by the three
    /// conditions themselves.
    pub(crate) fn holds(
        &self,
        bounds: &Bounds,
        joints: Option<&JointBounds>,
        allowed: &Allowed,
    ) -> bool {
        self.axes.hold(bounds.rows(), allowed, self.time())
            && joints.is_none_or(|j| self.joints.hold(j.rows(), allowed, self.time()))
    }

    /// Returns the joint that limits the speed most.
    pub(crate) fn tightest_joint(&self, j: &JointBounds) -> usize {
        let rows = self.joints.limits.iter().zip(&j.first).zip(&j.second);
        let ratio = |((l, a1), a2): ((&Limits, &f64), &f64)| {
            (a1 / l.velocity).max((a2 / l.acceleration).sqrt())
        };
        let ratios = rows.map(ratio).enumerate();
        ratios.fold((0, 0.0), |m, (k, r)| if r > m.1 { (k, r) } else { m }).0
    }
}

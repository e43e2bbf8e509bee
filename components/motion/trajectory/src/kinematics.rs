//! Kinematics: the joint positions for a pose, and bounds of their derivatives along the path.

use crate::{
    curve::Curve,
    machine::JOINTS,
    pose::{AXES, Pose},
    speed::JointBounds,
};

/// Positions of the joints.
pub type Joints = [f64; JOINTS];

/// A number with its first three derivatives by the path coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet(pub [f64; 4]);

/// Inverse kinematics of a machine. A joint without a position is reported as the error; one whose position or
/// derivative is NaN or infinite counts as one without.
pub trait Kinematics {
    /// Returns the joint positions for a pose, or the number of the joint that has none.
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize>;

    /// Returns the axis that drives each joint if every joint follows one axis; the limits of such joints are limits of
    /// the axes, and no bounds are needed.
    fn axes_of_joints(&self) -> Option<[Option<usize>; JOINTS]> {
        None
    }

    /// Returns the joints with their derivatives for a pose with its derivatives. `None` if this is not offered: the
    /// derivatives are then found by differences of [`Kinematics::inverse`].
    fn derivatives(&self, _pose: &[Jet; AXES]) -> Option<Result<[Jet; JOINTS], usize>> {
        None
    }
}

/// Every joint follows the axis of the same number.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trivial;

impl Kinematics for Trivial {
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize> {
        let mut joints = [0.0; JOINTS];
        for (j, x) in joints.iter_mut().zip(&pose.0) {
            *j = *x;
        }
        Ok(joints)
    }

    fn axes_of_joints(&self) -> Option<[Option<usize>; JOINTS]> {
        let mut map = [None; JOINTS];
        for (k, m) in map.iter_mut().take(AXES).enumerate() {
            *m = Some(k);
        }
        Some(map)
    }
}

/// Length of a cell for kinematics whose joints do not follow one axis each.
pub(crate) const CELL: f64 = 2.0;

/// Samples per cell.
const SAMPLES: u8 = 4;

/// Step of the differences where the kinematics offers no derivatives, at most.
const STEP: f64 = 0.05;

/// Share that is added to third derivatives found by differences.
const DIFFERENCE_RESERVE: f64 = 0.05;

/// Bounds the derivatives of the joints over a piece of a curve. The third derivative is sampled, with its largest change
/// between neighbouring samples as a reserve; the lower derivatives are bounded between samples by the higher ones. The
/// error is a joint without a position, and the pose where it has none.
pub(crate) fn joint_bounds<K: Kinematics + ?Sized>(
    kinematics: &K,
    curve: &Curve,
    from: f64,
    to: f64,
) -> Result<JointBounds, (usize, Pose)> {
    let width = (to - from) / f64::from(SAMPLES);
    let mut out = JointBounds { first: [0.0; JOINTS], second: [0.0; JOINTS], third: [0.0; JOINTS] };
    let mut change = [0.0_f64; JOINTS];
    let mut before: Option<[Jet; JOINTS]> = None;
    let mut extra = 0.0;
    for k in 0..=SAMPLES {
        let s = from + width * f64::from(k);
        let (jets, exact) =
            sample(kinematics, curve, s, to - from).map_err(|joint| (joint, curve.pose(s)))?;
        if !exact {
            extra = DIFFERENCE_RESERVE;
        }
        for (i, jet) in jets.iter().enumerate() {
            let [_, a, b, c] = jet.0;
            let slots = out.first.get_mut(i).zip(out.second.get_mut(i)).zip(out.third.get_mut(i));
            if let Some(((first, second), third)) = slots {
                *first = first.max(a.abs());
                *second = second.max(b.abs());
                *third = third.max(c.abs());
            }
        }
        if let Some(old) = before {
            for ((d, a), b) in change.iter_mut().zip(&old).zip(&jets) {
                *d = d.max((a.0[3] - b.0[3]).abs());
            }
        }
        before = Some(jets);
    }
    let rows = out.first.iter_mut().zip(&mut out.second).zip(&mut out.third).zip(&change);
    for (((first, second), third), change) in rows {
        *third = *third * (1.0 + extra) + *change + 1e-9 * extra;
        *second = *second * (1.0 + 0.02 * extra) + 0.5 * width * *third;
        *first = *first * (1.0 + 0.02 * extra) + 0.125 * width * width * *third;
    }
    Ok(out)
}

/// Joints with derivatives at `s`, all of them finite, and true if they are exact.
fn sample<K: Kinematics + ?Sized>(
    kinematics: &K,
    curve: &Curve,
    s: f64,
    width: f64,
) -> Result<([Jet; JOINTS], bool), usize> {
    let d = curve.at(s);
    let mut pose = [Jet::default(); AXES];
    let rows = d.pose.0.iter().zip(&d.first.0).zip(&d.second.0).zip(&d.third.0);
    for (jet, (((a, b), c), e)) in pose.iter_mut().zip(rows) {
        *jet = Jet([*a, *b, *c, *e]);
    }
    if let Some(jets) = kinematics.derivatives(&pose) {
        let jets = jets?;
        finite(&jets)?;
        return Ok((jets, true));
    }
    let e = STEP.min(0.25 * width).max(1e-4);
    let at = |k: f64| {
        // Taylor's expansion of the path, so that a step beyond the end of the curve stays on its continuation.
        let x = k * e;
        let p = d.pose + (d.first + (d.second * 0.5 + d.third * (x / 6.0)) * x) * x;
        kinematics.inverse(&p)
    };
    let (m2, m1, p0, p1, p2) = (at(-2.0)?, at(-1.0)?, at(0.0)?, at(1.0)?, at(2.0)?);
    let mut jets = [Jet::default(); JOINTS];
    let rows = m2.iter().zip(&m1).zip(&p0).zip(&p1).zip(&p2);
    for (jet, ((((m2, m1), p0), p1), p2)) in jets.iter_mut().zip(rows) {
        *jet = Jet([
            *p0,
            (8.0 * (p1 - m1) - (p2 - m2)) / (12.0 * e),
            (16.0 * (p1 + m1) - (p2 + m2) - 30.0 * p0) / (12.0 * e * e),
            (p2 - 2.0 * p1 + 2.0 * m1 - m2) / (2.0 * e * e * e),
        ]);
    }
    finite(&jets)?;
    Ok((jets, false))
}

/// Refuses values that are not finite with the number of their joint: NaN would pass every comparison with a limit.
fn finite(jets: &[Jet; JOINTS]) -> Result<(), usize> {
    match jets.iter().position(|jet| !jet.0.iter().all(|x| x.is_finite())) {
        Some(joint) => Err(joint),
        None => Ok(()),
    }
}

/// Arithmetic of jets: products and square roots by the rules of differentiation.
impl Jet {
    /// Jet of a constant.
    pub const fn constant(value: f64) -> Self {
        Self([value, 0.0, 0.0, 0.0])
    }

    /// Returns the square root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let [f, f1, f2, f3] = self.0;
        let g = f.sqrt();
        let g1 = f1 / (2.0 * g);
        let g2 = (f2 - 2.0 * g1 * g1) / (2.0 * g);
        let g3 = (f3 - 6.0 * g1 * g2) / (2.0 * g);
        Self([g, g1, g2, g3])
    }
}

impl core::ops::Add for Jet {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += b;
        }
        self
    }
}

impl core::ops::Sub for Jet {
    type Output = Self;
    fn sub(mut self, other: Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a -= b;
        }
        self
    }
}

impl core::ops::Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let ([a, a1, a2, a3], [b, b1, b2, b3]) = (self.0, other.0);
        Self([
            a * b,
            a1 * b + a * b1,
            a2 * b + 2.0 * a1 * b1 + a * b2,
            a3 * b + 3.0 * (a2 * b1 + a1 * b2) + a * b3,
        ])
    }
}

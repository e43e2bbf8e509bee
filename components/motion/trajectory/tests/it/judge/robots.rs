//! Machines whose joints do not follow one axis each. Programs lie around the pose 0, at the middle of the workspace.

use hal_trajectory::{AXES, JOINTS, Jet, Joints, Kinematics, Pose, Trivial};

/// Kinematics of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Robot {
    /// Joint n is axis n.
    Trivial,
    /// Two joints move Y.
    Gantry,
    /// Linear delta: three towers at radius 120 with rods of 250, with exact derivatives.
    Delta,
    /// The same without derivatives.
    PlainDelta,
    /// Two arms of 150 in a plane, a lift, and a turning tool.
    Scara,
    /// Six joints with a spherical wrist; A, B and C are quarters of degrees.
    Arm,
}

impl Robot {
    /// Robots in the order of random cases.
    pub const ALL: [Self; 11] = [
        Self::Trivial,
        Self::Gantry,
        Self::Trivial,
        Self::Delta,
        Self::Trivial,
        Self::Scara,
        Self::Trivial,
        Self::Arm,
        Self::Trivial,
        Self::PlainDelta,
        Self::Trivial,
    ];

    /// Returns the number of axes that programs may move; `None` if all of them.
    pub fn axes(self) -> Option<usize> {
        match self {
            Self::Trivial | Self::Gantry => None,
            Self::Delta | Self::PlainDelta | Self::Scara => Some(3),
            Self::Arm => Some(6),
        }
    }

    /// Returns true if a joint turns.
    pub fn turns(self, joint: usize) -> bool {
        match self {
            Self::Scara => joint != 2,
            Self::Arm => true,
            _ => false,
        }
    }
}

impl Kinematics for Robot {
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize> {
        match self {
            Self::Trivial => Trivial.inverse(pose),
            Self::Gantry => {
                let mut joints = Trivial.inverse(pose)?;
                joints[9] = pose.0[1];
                Ok(joints)
            }
            Self::Delta | Self::PlainDelta => delta(pose),
            Self::Scara => scara(pose),
            Self::Arm => arm(pose),
        }
    }

    fn axes_of_joints(&self) -> Option<[Option<usize>; JOINTS]> {
        let mut map = Trivial.axes_of_joints()?;
        match self {
            Self::Trivial => Some(map),
            Self::Gantry => {
                map[9] = Some(1);
                Some(map)
            }
            _ => None,
        }
    }

    fn derivatives(&self, pose: &[Jet; AXES]) -> Option<Result<[Jet; JOINTS], usize>> {
        if *self != Self::Delta {
            return None;
        }
        let mut joints = [Jet::default(); JOINTS];
        for (k, joint) in joints.iter_mut().take(3).enumerate() {
            let (x, y) = tower(k);
            let (dx, dy) = (pose[0] - Jet::constant(x), pose[1] - Jet::constant(y));
            let rest = Jet::constant(ROD * ROD) - dx * dx - dy * dy;
            if rest.0[0] <= 1.0 {
                return Some(Err(k));
            }
            *joint = pose[2] + rest.sqrt();
        }
        Some(Ok(joints))
    }
}

const ROD: f64 = 250.0;

fn tower(k: usize) -> (f64, f64) {
    [(0.0, 120.0), (-103.923, -60.0), (103.923, -60.0)][k]
}

fn delta(pose: &Pose) -> Result<Joints, usize> {
    let mut joints = [0.0; JOINTS];
    for (k, joint) in joints.iter_mut().take(3).enumerate() {
        let (x, y) = tower(k);
        let (dx, dy) = (pose.0[0] - x, pose.0[1] - y);
        let rest = ROD * ROD - dx * dx - dy * dy;
        if rest <= 1.0 {
            return Err(k);
        }
        *joint = pose.0[2] + rest.sqrt();
    }
    Ok(joints)
}

fn scara(pose: &Pose) -> Result<Joints, usize> {
    let (x, y) = (pose.0[0] + 190.0, pose.0[1]);
    let (first, second) = two_arms(x, y, 150.0, 150.0).ok_or(1_usize)?;
    let mut joints = [0.0; JOINTS];
    joints[0] = first.to_degrees();
    joints[1] = second.to_degrees();
    joints[2] = pose.0[2];
    joints[3] = pose.0[5] - joints[0] - joints[1];
    Ok(joints)
}

/// Angles of two arms that reach a point.
fn two_arms(x: f64, y: f64, a: f64, b: f64) -> Option<(f64, f64)> {
    let cos = (x * x + y * y - a * a - b * b) / (2.0 * a * b);
    if cos.abs() >= 0.999 {
        return None;
    }
    let second = -libm::acos(cos);
    let (s, c) = libm::sincos(second);
    Some((libm::atan2(y, x) - libm::atan2(b * s, a + b * c), second))
}

fn arm(pose: &Pose) -> Result<Joints, usize> {
    let quarter = |k: usize| (0.25 * pose.0[k]).to_radians();
    let ((sa, ca), (sb, cb), (sc, cc)) =
        (libm::sincos(quarter(3)), libm::sincos(quarter(4)), libm::sincos(quarter(5)));
    // Columns of Rz(c)·Ry(b)·Rx(a): the tool's x, and the tool's axis, which points down.
    let n = [cc * cb, sc * cb, -sb];
    let t = [-(cc * sb * ca + sc * sa), -(sc * sb * ca - cc * sa), -(cb * ca)];
    let tip = [pose.0[0] + 400.0, pose.0[1], pose.0[2] + 200.0];
    let wrist = [tip[0] - 80.0 * t[0], tip[1] - 80.0 * t[1], tip[2] - 80.0 * t[2]];
    let base = libm::atan2(wrist[1], wrist[0]);
    let out = (wrist[0] * wrist[0] + wrist[1] * wrist[1]).sqrt();
    let (second, third) = two_arms(out, wrist[2] - 300.0, 300.0, 280.0).ok_or(2_usize)?;
    let ((s1, c1), (s, c)) = (libm::sincos(base), libm::sincos(second + third));
    // The forearm, and two vectors at right angles to it.
    let (f, g, h) = ([c1 * c, s1 * c, s], [-c1 * s, -s1 * s, c], [s1, -c1, 0.0]);
    let (tf, tg, th) = (dot(&t, &f), dot(&t, &g), dot(&t, &h));
    let bend = (tg * tg + th * th).sqrt();
    if bend < 0.05 {
        return Err(4);
    }
    let axis = cross(&f, &t);
    let side = cross(&t, &axis);
    let angles = [
        base,
        second,
        third,
        libm::atan2(-th, -tg),
        libm::atan2(bend, tf),
        libm::atan2(dot(&n, &side), dot(&n, &axis)),
    ];
    let mut joints = [0.0; JOINTS];
    for (j, a) in joints.iter_mut().zip(angles) {
        *j = a.to_degrees();
    }
    Ok(joints)
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

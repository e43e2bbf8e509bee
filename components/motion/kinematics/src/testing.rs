//! Tests that all kinematics share: do forward and inverse agree, and what happens at the edges.

use crate::rotation::{from_abc, to_vector};
use hal_bench::{Bench, Random};
use hal_component::{Component, KinematicsRef, Pose, Unsolved};
use nalgebra::DMatrix;

/// Kinematics on the bench.
pub(crate) struct Rig {
    pub(crate) bench: Bench,
    pub(crate) k: KinematicsRef,
}

impl Rig {
    pub(crate) fn new<C: Component>(args: &[&str]) -> Self {
        let mut bench = Bench::new();
        bench.load::<C>(args).unwrap_or_else(|e| panic!("{}: {e}", C::NAME));
        let k = bench.find();
        Self { bench, k }
    }

    pub(crate) fn set(&self, pins: &[(&str, f64)]) {
        for (name, value) in pins {
            self.bench.set(name, *value);
        }
    }

    /// Returns the pose of these joints, from a guess of zeros.
    pub(crate) fn pose(&self, joints: &[f64]) -> Pose {
        let mut all = [0.0; 16];
        all[..joints.len()].copy_from_slice(joints);
        let mut pose = [0.0; 9];
        self.k.forward(&all, &mut pose).unwrap_or_else(|e| panic!("{joints:?}: {e:?}"));
        pose
    }

    /// Returns the joints for a pose, from a guess of zeros.
    pub(crate) fn joints(&self, pose: Pose) -> [f64; 16] {
        let mut joints = [0.0; 16];
        self.k.inverse(&pose, &mut joints).unwrap_or_else(|e| panic!("{pose:?}: {e:?}"));
        joints
    }

    /// Returns the reason why a pose has no joints; asserts that the joints stay unchanged.
    pub(crate) fn no_joints(&self, pose: Pose) -> Unsolved {
        let mut joints = [0.25; 16];
        let why = self.k.inverse(&pose, &mut joints).expect_err(&format!("{pose:?}"));
        assert_eq!(joints, [0.25; 16]);
        why
    }

    /// Returns the reason why joints have no pose; asserts that the pose stays unchanged.
    pub(crate) fn no_pose(&self, joints: &[f64]) -> Unsolved {
        let mut all = [0.0; 16];
        all[..joints.len()].copy_from_slice(joints);
        let mut pose = [0.25; 9];
        let why = self.k.forward(&all, &mut pose).expect_err(&format!("{joints:?}"));
        assert_eq!(pose, [0.25; 9]);
        why
    }

    /// Returns every solution for a pose.
    pub(crate) fn ways(&self, pose: &Pose) -> Vec<Vec<f64>> {
        let n = self.k.joints();
        let mut into = vec![0.0; n * 32];
        let found = self.k.solutions(pose, &mut into).unwrap();
        into.chunks(n).take(found).map(<[f64]>::to_vec).collect()
    }
}

/// Asserts that numbers are close to each other.
#[track_caller]
pub(crate) fn close(a: &[f64], b: &[f64], within: f64) {
    assert_eq!(a.len(), b.len());
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() <= within, "{a:?} is not {b:?}");
    }
}

/// Range of one joint.
#[derive(Clone, Copy)]
pub(crate) struct Joint {
    pub(crate) range: (f64, f64),
    /// Selects the unit: 1 radian for a rotary joint, else the size of the machine.
    is_rotary: bool,
}

impl Joint {
    pub(crate) const fn rotary(most: f64) -> Self {
        Self { range: (-most, most), is_rotary: true }
    }
    pub(crate) const fn linear(most: f64) -> Self {
        Self { range: (-most, most), is_rotary: false }
    }
    pub(crate) const fn linear_from(low: f64, high: f64) -> Self {
        Self { range: (low, high), is_rotary: false }
    }
    fn unit(&self, size: f64) -> f64 {
        if self.is_rotary { 1f64.to_degrees() } else { size }
    }
}

/// Range in which a machine is tested.
#[derive(Clone, Copy)]
pub(crate) struct Space<'a> {
    /// Size of its workspace, in units.
    pub(crate) size: f64,
    pub(crate) joints: &'a [Joint],
    /// Letters of the pose that its joints determine.
    pub(crate) letters: &'a [usize],
    /// True if A B C are roll, pitch and yaw, false if each is an axis.
    pub(crate) abc: bool,
    /// Values of pins.
    pub(crate) set: &'a [(&'a str, f64)],
    /// Distance of a guess from the solution, as a fraction of a unit.
    pub(crate) aside: f64,
    /// Ranges of random poses, which are used instead of random joints.
    pub(crate) poses: &'a [(f64, f64)],
    /// Minimum number of regular positions among [`ROUNDS`].
    pub(crate) least: usize,
    /// Type of kinematics.
    pub(crate) switch: u32,
    /// True if some joints have poses that the inverse cannot reach.
    pub(crate) has_gaps: bool,
}

impl Space<'_> {
    pub(crate) const DEFAULT: Space<'static> = Space {
        size: 1.0,
        joints: &[],
        letters: &[0, 1, 2, 3, 4, 5, 6, 7, 8],
        abc: false,
        set: &[],
        aside: 1e-3,
        poses: &[],
        least: ROUNDS,
        switch: 0,
        has_gaps: false,
    };

    /// Returns the differences of two poses: lengths as fractions of the size, angles in radians.
    pub(crate) fn apart(&self, a: &Pose, b: &Pose) -> Vec<f64> {
        let mut out = Vec::new();
        for l in self.letters {
            let way = a[*l] - b[*l];
            out.push(match l {
                3..=5 if !self.abc => way.to_radians(),
                3..=5 => 0.0,
                _ => way / self.size,
            });
        }
        if self.abc {
            let [a, b] = [a, b].map(|p| from_abc([p[3], p[4], p[5]]));
            out.extend(to_vector(&(a * b.transpose())).iter());
        }
        out
    }
}

/// Number of positions tested.
pub(crate) const ROUNDS: usize = 4000;

/// Condition number above which a position counts as singular.
const WORST: f64 = 1e6;

fn most(list: &[f64]) -> f64 {
    list.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Tests random joints: the inverse of their pose must return to the pose, and to the same joints wherever the machine
/// is not singular.
pub(crate) fn serial<C: Component>(args: &[&str], space: &Space<'_>) {
    let rig = Rig::new::<C>(args);
    rig.set(space.set);
    assert!(rig.k.switch(space.switch));
    let n = space.joints.len();
    assert_eq!(rig.k.joints(), n, "joints");
    let mut random = Random::new(C::NAME.len() as u64);
    let (mut regular, mut worst) = (0, 0.0f64);
    for round in 0..ROUNDS {
        let joints: Vec<f64> =
            space.joints.iter().map(|j| random.between(j.range.0, j.range.1)).collect();
        let mut pose = [0.0; 9];
        if let Err(why) = rig.k.forward(&joints, &mut pose) {
            assert!(space.has_gaps, "{round}: {joints:?}: {why:?}");
            continue;
        }
        assert!(pose.iter().all(|p| p.is_finite()));
        let Some(condition) = condition(&rig, space, &joints, &pose) else { continue };
        if condition.is_nan() || condition >= WORST {
            continue;
        }
        let aside = |random: &mut Random, unit: f64| random.unit() * space.aside * unit;
        let mut back: Vec<f64> = joints
            .iter()
            .zip(space.joints)
            .map(|(p, j)| p + aside(&mut random, j.unit(space.size)) / condition.max(1.0))
            .collect();
        rig.k.inverse(&pose, &mut back).unwrap_or_else(|e| panic!("{round}: {joints:?}: {e:?}"));
        let mut again = pose;
        rig.k.forward(&back, &mut again).unwrap_or_else(|e| panic!("{round}: {back:?}: {e:?}"));
        let off = most(&space.apart(&again, &pose));
        assert!(off < 1e-9, "{round}: {joints:?} {pose:?} {again:?}: {off}, cond {condition}");
        for ((a, b), j) in joints.iter().zip(&back).zip(space.joints) {
            let off = (a - b).abs() / j.unit(space.size);
            assert!(off < 1e-9 * condition.max(1.0), "{round}: {joints:?} {back:?}: {condition}");
        }
        worst = worst.max(off);
        regular += 1;
    }
    assert!(regular >= space.least, "only {regular} of {ROUNDS} places were regular");
    crate::edges::edges::<C>(args, space);
}

/// Returns the condition number of the Jacobian from joints to pose, by finite differences.
fn condition(rig: &Rig, space: &Space<'_>, joints: &[f64], pose: &Pose) -> Option<f64> {
    const STEP: f64 = 1e-6;
    let mut columns = Vec::new();
    for (i, j) in space.joints.iter().enumerate() {
        let mut ends = [*pose; 2];
        for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
            let mut beside = joints.to_vec();
            beside[i] += sign * STEP * j.unit(space.size);
            rig.k.forward(&beside, end).ok()?;
        }
        columns.push(space.apart(&ends[0], &ends[1]).iter().map(|d| d / (2.0 * STEP)).collect());
    }
    Some(ratio(&columns))
}

/// Returns the ratio of the largest to the smallest singular value.
fn ratio(columns: &[Vec<f64>]) -> f64 {
    let rows = columns[0].len();
    let matrix = DMatrix::from_fn(rows, columns.len(), |r, c| columns[c][r]);
    let values = matrix.singular_values();
    let mut list: Vec<f64> = values.iter().copied().collect();
    list.sort_by(|a, b| b.total_cmp(a));
    list[0] / list[columns.len() - 1]
}

/// Tests random poses: the pose of their joints must be the same wherever the machine is not singular.
pub(crate) fn parallel<C: Component>(args: &[&str], space: &Space<'_>) {
    const STEP: f64 = 1e-6;
    let rig = Rig::new::<C>(args);
    rig.set(space.set);
    assert!(rig.k.switch(space.switch));
    let mut random = Random::new(C::NAME.len() as u64);
    let mut regular = 0;
    for round in 0..ROUNDS {
        let mut pose = [0.0; 9];
        for (l, range) in space.letters.iter().zip(space.poses) {
            pose[*l] = random.between(range.0, range.1);
        }
        let mut joints = [0.0; 16];
        if rig.k.inverse(&pose, &mut joints).is_err() {
            assert!(space.has_gaps, "{round}: {pose:?}");
            continue;
        }
        // Jacobian of the joints with respect to the pose, by finite differences: the same condition number.
        let mut columns = Vec::new();
        for l in space.letters {
            let unit = if (3..6).contains(l) { 1f64.to_degrees() } else { space.size };
            let ends = [1.0, -1.0].map(|sign| {
                let (mut beside, mut ends) = (pose, joints);
                beside[*l] += sign * STEP * unit;
                rig.k.inverse(&beside, &mut ends).map(|_| ends)
            });
            if let [Ok(a), Ok(b)] = ends {
                let units = space.joints.iter().map(|j| j.unit(space.size));
                let ways = a.iter().zip(&b).zip(units);
                columns.push(ways.map(|((a, b), u)| (a - b) / (2.0 * STEP * u)).collect());
            }
        }
        if columns.len() < space.letters.len() {
            continue;
        }
        let condition = ratio(&columns);
        if condition.is_nan() || condition >= WORST {
            continue;
        }
        let mut back = pose;
        for l in space.letters {
            let unit = if (3..6).contains(l) { 1f64.to_degrees() } else { space.size };
            back[*l] += random.unit() * space.aside * unit / condition.max(1.0);
        }
        rig.k.forward(&joints, &mut back).unwrap_or_else(|e| panic!("{round}: {pose:?}: {e:?}"));
        let off = most(&space.apart(&back, &pose));
        assert!(off < 1e-9, "{round}: {pose:?} {back:?}: {off}");
        regular += 1;
    }
    assert!(regular >= space.least, "only {regular} of {ROUNDS} places were regular");
    crate::edges::edges::<C>(args, space);
}

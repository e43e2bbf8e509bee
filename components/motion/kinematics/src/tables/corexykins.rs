//! `corexykins`.

use crate::{
    model::{Found, Joints, Model, Service, pass},
    names::{example, names},
};
use hal_component::{Builder, Error, Pose, Solved, Touch};

const DOC: &str = concat!(
    "\
Kinematics of a CoreXY machine: two motors that stand still move X and Y by two crossed belts.

X is half the sum of joints 0 and 1, Y half their difference; Z is joint 2, and joints 3 to 8 are
A B C U V W (Moyer, CoreXY Cartesian motion platform, 2012). It has no pins and no functions; load
it before `motmod`.",
    example!("corexykins", 3, "", "motion.move x=10 y=5 --wait\nshow pin joint.*.pos-cmd\n")
);

names! {
    DOC, &[], create;
    /// `loadrt corexykins`.
    Corexykins = "corexykins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    b.offer_kinematics(Service(Belts {}))
}

#[derive(Debug, Touch)]
struct Belts {}

impl Model for Belts {
    type Geometry = ();

    fn joints(&self) -> usize {
        9
    }

    fn geometry(&self) -> Option<()> {
        Some(())
    }

    fn forward(&self, (): &(), joints: &Joints, _: &Pose) -> Found<Pose> {
        let mut pose = [0.0; 9];
        pass(joints, 0, &mut pose, 0, 9);
        pose[0] = 0.5 * (joints[0] + joints[1]);
        pose[1] = 0.5 * (joints[0] - joints[1]);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut joints = *guess;
        pass(pose, 0, &mut joints, 0, 9);
        joints[0] = pose[0] + pose[1];
        joints[1] = pose[0] - pose[1];
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Space, serial};

    #[test]
    fn both_ways() {
        let joints = [Joint::linear(500.0); 9];
        serial::<Corexykins>(&[], &Space { size: 1000.0, joints: &joints, ..Space::DEFAULT });
    }

    #[test]
    fn as_the_belts_run() {
        let rig = crate::testing::Rig::new::<Corexykins>(&[]);
        assert_eq!(rig.joints([1., 2., 3., 4., 5., 6., 7., 8., 9.])[..4], [3., -1., 3., 4.]);
        assert_eq!(rig.pose(&[1., 2., 3., 4., 5., 6., 7., 8., 9.])[..4], [1.5, -0.5, 3., 4.]);
    }
}

//! `rotatekins`.

use crate::{
    model::{Found, Joints, Model, Service, pass},
    names::{example, names},
    rotation::{Vector, about_z},
};
use hal_component::{Builder, Error, Pose, Solved, Touch};

const DOC: &str = concat!(
    "\
Kinematics of a machine whose X and Y stand on a rotary axis C.

Joints 0 and 1 are X and Y turned by C degrees, so that a straight line stays one while C turns;
Z is joint 2, and joints 3 to 8 are A B C U V W. It has no pins and no functions; load it before
`motmod`.",
    example!("rotatekins", 6, "", "motion.move x=10 c=90 --wait\nshow pin joint.*.pos-cmd\n")
);

names! {
    DOC, &[], create;
    /// `loadrt rotatekins`.
    Rotatekins = "rotatekins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    b.offer_kinematics(Service(Turned {}))
}

#[derive(Debug, Touch)]
struct Turned {}

fn turned(x: f64, y: f64, degrees: f64) -> Vector {
    about_z(degrees.to_radians()) * Vector::new(x, y, 0.0)
}

impl Model for Turned {
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
        let place = turned(joints[0], joints[1], -joints[5]);
        (pose[0], pose[1]) = (place.x, place.y);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut joints = *guess;
        pass(pose, 0, &mut joints, 0, 9);
        let place = turned(pose[0], pose[1], pose[5]);
        (joints[0], joints[1]) = (place.x, place.y);
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};

    #[test]
    fn both_ways() {
        let mut joints = [Joint::linear(500.0); 9];
        joints[3..6].fill(Joint::rotary(360.0));
        serial::<Rotatekins>(&[], &Space { size: 1000.0, joints: &joints, ..Space::DEFAULT });
    }

    #[test]
    fn a_quarter_turn() {
        let rig = Rig::new::<Rotatekins>(&[]);
        close(&rig.joints([1., 2., 3., 0., 0., 90., 0., 0., 0.])[..3], &[-2., 1., 3.], 1e-15);
    }
}

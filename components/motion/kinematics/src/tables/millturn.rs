//! `millturn`.

use crate::{
    echo::{Echo, demonstrate},
    instances::{COUNT, NAMES},
    letters::{ANY, Letters},
    model::{Found, Joints, Model, pass},
    names::{example, names},
    switch::Switched,
};
use hal_component::{Builder, Error, Pose, Solved, Touch};

const DOC: &str = concat!(
    "\
Kinematics of a machine that mills and turns: the same axes, seen as a mill or as a lathe.

Joints 0 to 3 are X Y Z A of the mill in type 0, where A is a rotary axis. In type 1, chosen by
`motion.switchkins-type`, they are Z, -Y, X and A of the lathe, whose spindle A is: the mill's X runs
along the spindle. The pose changes with the type, the joints do not. Each of `count=` or `names=` has
a pin and a function that show how those are made.",
    example!(
        "millturn",
        4,
        "",
        "motion.move x=10 y=5 z=-3 --wait\nsetp motion.switchkins-type 1\nrun 1ms\n\
         show pin axis.*.pos-cmd joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[&COUNT, &NAMES], create;
    /// `loadrt millturn`.
    Millturn = "millturn";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    demonstrate(b, "millturn")?;
    let echo = Echo::make(b, "millturn")?;
    let model = |lathe| Some(Turned { lathe, echo: echo.clone() });
    let models = vec![model(false), model(true)];
    let kinematics = Switched::make(b, models, Letters::parse("XYZA", ANY)?)?;
    b.offer_kinematics(kinematics)
}

#[derive(Debug, Touch)]
struct Turned {
    #[state]
    lathe: bool,
    echo: Echo,
}

impl Turned {
    /// Swaps the axes for a lathe; the same in both directions.
    fn turn(&self, from: &[f64; 3]) -> [f64; 3] {
        let [x, y, z] = *from;
        if self.lathe { [z, -y, x] } else { [x, y, z] }
    }
}

impl Model for Turned {
    type Geometry = ();

    fn joints(&self) -> usize {
        4
    }

    fn geometry(&self) -> Option<()> {
        Some(())
    }

    fn forward(&self, (): &(), joints: &Joints, guess: &Pose) -> Found<Pose> {
        let mut pose = *guess;
        pass(&self.turn(&[joints[0], joints[1], joints[2]]), 0, &mut pose, 0, 3);
        pose[3] = joints[3];
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        self.echo.repeat();
        let mut joints = *guess;
        pass(&self.turn(&[pose[0], pose[1], pose[2]]), 0, &mut joints, 0, 3);
        joints[3] = pose[3];
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, serial};

    #[test]
    fn both_ways() {
        let line = Joint::linear(500.0);
        let joints = &[line, line, line, Joint::rotary(360.0)];
        for switch in [0, 1] {
            let letters = &[0, 1, 2, 3];
            let space = Space { size: 1000.0, joints, letters, switch, ..Space::DEFAULT };
            serial::<Millturn>(&[], &space);
        }
    }

    #[test]
    fn a_mill_and_a_lathe() {
        let rig = Rig::new::<Millturn>(&[]);
        assert_eq!(rig.k.types(), 2);
        assert_eq!(rig.pose(&[1., 2., 3., 4.])[..4], [1., 2., 3., 4.]);
        assert!(rig.k.switch(1));
        assert_eq!(rig.pose(&[1., 2., 3., 4.])[..4], [3., -2., 1., 4.]);
        assert_eq!(rig.joints([3., -2., 1., 4., 0., 0., 0., 0., 0.])[..4], [1., 2., 3., 4.]);
    }
}

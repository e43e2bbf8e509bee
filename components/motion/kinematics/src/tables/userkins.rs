//! `userkins`.

use crate::{
    echo::Echo,
    instances::{COUNT, NAMES},
    model::{Found, Joints, Model, Service, pass},
    names::{example, names},
};
use hal_component::{Builder, Error, Pose, Solved, Touch};

const DOC: &str = concat!(
    "\
An example of kinematics to begin one's own with: joints 0 to 2 are X Y Z.

Copy its file (`components/motion/kinematics/src/tables/userkins.rs`) into a library of your own, under another
name; write what your joints do into `forward` and `inverse`, and the pins with your lengths beside
them. Each of `count=` or `names=` has a pin and a function to show how those are made;
`userkins.in` comes out of `userkins.out` whenever joints are computed.",
    example!(
        "userkins",
        3,
        "setp userkins.in 5\naddf userkins.0.fdemo servo-thread\n",
        "motion.move x=10 y=5 --wait\nshow pin userkins.* joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[&COUNT, &NAMES], create;
    /// `loadrt userkins`.
    Userkins = "userkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    crate::echo::demonstrate(b, "userkins")?;
    let echo = Echo::make(b, "userkins")?;
    b.offer_kinematics(Service(Straight { echo }))
}

/// State of the kinematics: pins with lengths, if there are any.
#[derive(Debug, Touch)]
struct Straight {
    echo: Echo,
}

impl Model for Straight {
    /// Lengths, read once per query. This machine has none.
    type Geometry = ();

    fn joints(&self) -> usize {
        3
    }

    /// Returns `None` if the lengths are invalid: then every query fails.
    fn geometry(&self) -> Option<()> {
        Some(())
    }

    /// Returns the pose of these joints. Letters that no joint moves keep the guess. Return an error such as
    /// `Err(Unsolved::Unreachable)` where there is no pose.
    fn forward(&self, (): &(), joints: &Joints, guess: &Pose) -> Found<Pose> {
        let mut pose = *guess;
        pass(joints, 0, &mut pose, 0, 3);
        Ok((pose, Solved::Regular))
    }

    /// Returns the joints for a pose; the guess is their present position.
    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        self.echo.repeat();
        let mut joints = *guess;
        pass(pose, 0, &mut joints, 0, 3);
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, serial};

    #[test]
    fn both_ways() {
        let joints = [Joint::linear(500.0); 3];
        let letters = &[0, 1, 2];
        serial::<Userkins>(
            &[],
            &Space { size: 1000.0, joints: &joints, letters, ..Space::DEFAULT },
        );
    }

    #[test]
    fn what_it_shows() {
        let rig = Rig::new::<Userkins>(&["names=one,two"]);
        rig.bench.set("userkins.in", 7_u32);
        rig.joints([0.0; 9]);
        assert_eq!(rig.bench.get::<u32>("userkins.out"), 7);
        assert_eq!(rig.bench.functs(), ["one.fdemo", "two.fdemo"]);
        rig.bench.run("two.fdemo", 1_000_000);
        for (args, text) in [
            (&["count=0"][..], "count is 0, must be between 1 and 16"),
            (&["count=2", "names=a,b"], "count= and names= are mutually exclusive"),
        ] {
            let refused = hal_bench::Bench::new().load::<Userkins>(args);
            assert_eq!(refused.unwrap_err(), text);
        }
    }
}

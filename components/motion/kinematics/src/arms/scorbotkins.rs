//! `scorbot-kins`.

use crate::{
    model::{Found, Joints, Model, Service, pass},
    names::{example, names},
    parallel::circles::{bend, shoulder},
    rotation::{is_straight, near},
};
use hal_component::{Builder, Error, Pose, Solution, Solved, Touch, Ways};
use libm::{atan2, cos, hypot, sin};

const DOC: &str = concat!(
    "\
Kinematics of the Scorbot ER-3, a teaching arm.

Joint 0 turns the body, joints 1 and 2 are the angles of upper arm and forearm against the level
ground, in degrees: the forearm keeps its direction when the upper arm moves. X Y Z are the wrist,
in millimetres; A and B are joints 3 and 4 as they are (Craig, Introduction to Robotics, section
4.4). The elbow is always above. It has no pins: both links are 221 long, the shoulder is 16 before
the axis of the body and 140 above the ground. Straight above the body, and stretched out, it is at
a singular place; what is out of reach is refused. `scorbotkins` and `scorbot_kins` are other names
for it.",
    example!(
        "scorbot-kins",
        5,
        "",
        "motion.jog joint=2 velocity=90 position=-45 --wait\nmotion.move x=300 y=50 z=200 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt scorbot-kins`.
    ScorbotKins = "scorbot-kins";
    /// `loadrt scorbotkins`: the same.
    Scorbotkins = "scorbotkins";
    /// `loadrt scorbot_kins`: the same.
    ScorbotPlain = "scorbot_kins";
}

/// Horizontal distance from the axis of the body to the shoulder.
const FORWARD: f64 = 16.0;
/// Height of the shoulder.
const UP: f64 = 140.0;
/// Length of each link.
const LINK: f64 = 221.0;

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    b.offer_kinematics(Service(Arm {}))
}

#[derive(Debug, Touch)]
struct Arm {}

/// Returns the joints for an elbow angle: elbow up, or elbow down if the angle is above 0.
fn reach(pose: &Pose, guess: &Joints, elbow: f64) -> Joints {
    let out = hypot(pose[0], pose[1]);
    let mut joints = *guess;
    if out > 0.0 {
        joints[0] = near(atan2(pose[1], pose[0]).to_degrees(), guess[0]);
    }
    let upper = shoulder(out - FORWARD, pose[2] - UP, LINK, LINK, elbow);
    joints[1] = upper.to_degrees();
    joints[2] = (upper + elbow).to_degrees();
    pass(pose, 3, &mut joints, 3, 2);
    joints
}

impl Model for Arm {
    type Geometry = ();

    fn joints(&self) -> usize {
        5
    }

    fn geometry(&self) -> Option<()> {
        Some(())
    }

    fn forward(&self, (): &(), joints: &Joints, guess: &Pose) -> Found<Pose> {
        let [body, upper, fore] = [joints[0], joints[1], joints[2]].map(f64::to_radians);
        let out = FORWARD + LINK * (cos(upper) + cos(fore));
        let mut pose = *guess;
        pose[0] = out * cos(body);
        pose[1] = out * sin(body);
        pose[2] = UP + LINK * (sin(upper) + sin(fore));
        pass(joints, 3, &mut pose, 3, 2);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        let out = hypot(pose[0], pose[1]);
        let (x, z) = (out - FORWARD, pose[2] - UP);
        let bend = bend(x * x + z * z, LINK, LINK)?;
        let above = is_straight(out / LINK);
        let solved = if above { Solved::Singular } else { bend.solved };
        Ok((reach(pose, guess, -bend.elbow), solved))
    }

    fn solutions(&self, (): &(), pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let (joints, solved) = self.inverse(&(), pose, &[0.0; 16])?;
        ways.push(&joints);
        if solved == Solved::Regular {
            let elbow = (joints[1] - joints[2]).to_radians();
            ways.push(&reach(pose, &[0.0; 16], elbow));
        }
        Ok(solved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, parallel};
    use hal_component::Unsolved;

    #[test]
    fn both_ways() {
        let turn = Joint::rotary(180.0);
        let poses = &[(-450., 450.), (-450., 450.), (-300., 580.), (-180., 180.), (-180., 180.)];
        let space = Space {
            size: 450.0,
            joints: &[turn; 5],
            letters: &[0, 1, 2, 3, 4],
            poses,
            has_gaps: true,
            least: 1500,
            ..Space::DEFAULT
        };
        parallel::<ScorbotKins>(&[], &space);
    }

    #[test]
    fn its_places() {
        let rig = Rig::new::<ScorbotKins>(&[]);
        close(&rig.pose(&[0.0; 5])[..3], &[458., 0., 140.], 1e-12);
        close(&rig.pose(&[90., 90., 0., 7., 8.])[..5], &[0., 237., 361., 7., 8.], 1e-9);
        close(&rig.joints([237., 0., 361., 0., 0., 0., 0., 0., 0.])[..3], &[0., 90., 0.], 1e-9);
        let ways = rig.ways(&[237., 0., 361., 0., 0., 0., 0., 0., 0.]);
        close(&ways[1][..3], &[0., 0., 90.], 1e-9);
        let far = [1000., 0., 0., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_joints(far), Unsolved::Unreachable);
        // Above the body's axis, any direction is a solution: joint 0 stays.
        let mut joints = [25., 0., 0., 0., 0.];
        let above = [0., 0., 400., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.k.inverse(&above, &mut joints), Ok(Solved::Singular));
        assert_eq!(joints[0], 25.0);
    }
}

//! `scarakins`.

use crate::{
    model::{Found, Joints, Model, are_lengths, is_finite, pass},
    names::{example, names},
    parallel::circles::{bend, shoulder},
    rotation::near,
    switch::{COORDINATES, SPARM, Switched},
};
use hal_component::{
    Builder, Error, In, Pose, Solution, Solved, Unsolved, Ways, abi::ArgSpec, pins,
};
use libm::{cos, hypot, sin, sqrt};

const DOC: &str = concat!(
    "\
Kinematics of a SCARA arm: two links that turn about upright axes, a spindle and a hand.

Joint 0 turns the inner arm, joint 1 the outer one against it, joint 2 lowers the spindle, joint 3
turns the hand; angles are in degrees. The pose is X Y Z and the direction C of the hand; joints 4
and 5 are A and B. The elbow stays on the side where joint 1 is (Craig, Introduction to Robotics,
section 4.4). Stretched out or folded back the arm is at a singular place; what is farther or nearer
than the links reach is refused. Lengths D2 and D4 must be above 0.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "scarakins",
        4,
        "setp scarakins.D6 0\n",
        "motion.jog joint=1 velocity=90 position=45 --wait\nmotion.move x=400 y=200 z=450 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[&COORDINATES.or("XYZABC"), &SPARM];

names! {
    DOC, ARGS, create;
    /// `loadrt scarakins`.
    Scarakins = "scarakins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    Switched::offer_six(b, |b| Pins::make(b, "scarakins"))
}

pins! {
    /// Lengths of the arm.
    struct Pins {
        /// Height of the middle of the inner arm above the ground, in units.
        d1: In<f64> = "D1", 490.0;
        /// Length of the inner arm, from the axis of joint 0 to that of joint 1, in units; above 0.
        d2: In<f64> = "D2", 340.0;
        /// Height of the outer arm's middle above that of the inner arm, in units; below 0: lower.
        d3: In<f64> = "D3", 50.0;
        /// Length of the outer arm, from the axis of joint 1 to that of joints 2 and 3, in units; above 0.
        d4: In<f64> = "D4", 250.0;
        /// Distance from the end of the arm down to the tool tip with joint 2 at 0, in units.
        d5: In<f64> = "D5", 50.0;
        /// Distance from the axis of the hand to the tool tip, in units; 0: on the axis, below 0: on the other side.
        d6: In<f64> = "D6", 50.0;
    }
}

/// Lengths of inner link, outer link and hand, and the height of the tip, in units.
struct Arm {
    inner: f64,
    outer: f64,
    hand: f64,
    height: f64,
}

impl Arm {
    /// Returns the joints for an elbow angle, whose sign selects the side.
    fn reach(&self, pose: &Pose, guess: &Joints, elbow: f64) -> Joints {
        let [x, y] = self.wrist(pose);
        let first = if hypot(x, y) > ROUNDING * (self.inner + self.outer) {
            near(shoulder(x, y, self.inner, self.outer, elbow).to_degrees(), guess[0])
        } else {
            guess[0]
        };
        let second = near(elbow.to_degrees(), guess[1]);
        let mut joints = *guess;
        joints[0] = first;
        joints[1] = second;
        joints[2] = self.height - pose[2];
        joints[3] = pose[5] - first - second;
        pass(pose, 3, &mut joints, 4, 2);
        joints
    }

    /// Returns X and Y of the hand's axis.
    fn wrist(&self, pose: &Pose) -> [f64; 2] {
        let c = pose[5].to_radians();
        [pose[0] - self.hand * cos(c), pose[1] - self.hand * sin(c)]
    }

    fn bend(&self, pose: &Pose) -> Result<crate::parallel::circles::Bend, Unsolved> {
        let [x, y] = self.wrist(pose);
        bend(x * x + y * y, self.inner, self.outer)
    }
}

/// Distance that counts as 0, as a fraction of the arm's length.
const ROUNDING: f64 = 1e-14;

impl Model for Pins {
    type Geometry = Arm;

    fn joints(&self) -> usize {
        6
    }

    fn geometry(&self) -> Option<Arm> {
        let [d1, d2, d3, d4, d5, d6] =
            [&self.d1, &self.d2, &self.d3, &self.d4, &self.d5, &self.d6].map(In::get);
        let height = d1 + d3 - d5;
        (are_lengths(&[d2, d4]) && is_finite(&[d1, d3, d5, d6])).then_some(Arm {
            inner: d2,
            outer: d4,
            hand: d6,
            height,
        })
    }

    fn forward(&self, g: &Arm, joints: &Joints, guess: &Pose) -> Found<Pose> {
        let first = joints[0].to_radians();
        let second = first + joints[1].to_radians();
        let hand = second + joints[3].to_radians();
        let mut pose = *guess;
        pose[0] = g.inner * cos(first) + g.outer * cos(second) + g.hand * cos(hand);
        pose[1] = g.inner * sin(first) + g.outer * sin(second) + g.hand * sin(hand);
        pose[2] = g.height - joints[2];
        pass(joints, 4, &mut pose, 3, 2);
        pose[5] = joints[0] + joints[1] + joints[3];
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, g: &Arm, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let bend = g.bend(pose)?;
        // Solution on the side where the elbow is now.
        let side = sin(guess[1].to_radians());
        let elbow = if side < 0.0 { -bend.elbow } else { bend.elbow };
        Ok((g.reach(pose, guess, elbow), bend.solved))
    }

    fn solutions(&self, g: &Arm, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let bend = g.bend(pose)?;
        let none = [0.0; 16];
        ways.push(&g.reach(pose, &none, bend.elbow));
        if sqrt(bend.elbow * (core::f64::consts::PI - bend.elbow)) > 0.0 {
            ways.push(&g.reach(pose, &none, -bend.elbow));
        }
        Ok(bend.solved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};

    const LETTERS: &[usize] = &[0, 1, 2, 3, 4, 5];

    #[test]
    fn both_ways() {
        let (line, turn) = (Joint::linear(200.0), Joint::rotary(175.0));
        let joints = [turn, turn, line, turn, turn, turn];
        for d6 in [0.0, 50.0, -30.0] {
            let set: &[(&str, f64)] = &[("scarakins.D6", d6)];
            let space = Space {
                size: 590.0,
                joints: &joints,
                letters: LETTERS,
                set,
                least: 3900,
                ..Space::DEFAULT
            };
            serial::<Scarakins>(&[], &space);
        }
    }

    #[test]
    fn both_elbows() {
        let rig = Rig::new::<Scarakins>(&[]);
        let pose = rig.pose(&[10., 40., 20., 30., 0., 0.]);
        let ways = rig.ways(&pose);
        assert_eq!(ways.len(), 2);
        close(&ways[0], &[10., 40., 20., 30., 0., 0.], 1e-9);
        close(&ways[1][1..2], &[-40.0], 1e-9);
        for way in ways {
            close(&rig.pose(&way), &pose, 1e-9);
        }
        let mut joints = [0., -1., 0., 0., 0., 0.];
        rig.k.inverse(&pose, &mut joints).unwrap();
        close(&joints[1..2], &[-40.0], 1e-9);
    }

    #[test]
    fn the_edge_of_what_it_reaches() {
        let rig = Rig::new::<Scarakins>(&[]);
        let at = |x: f64| [x, 0., 450., 0., 0., 0., 0., 0., 0.];
        let mut joints = [0.0; 6];
        assert_eq!(rig.k.inverse(&at(640.0), &mut joints), Ok(Solved::Singular));
        close(&joints, &[0., 0., 40., 0., 0., 0.], 1e-9);
        assert_eq!(rig.no_joints(at(640.001)), Unsolved::Unreachable);
        assert_eq!(rig.no_joints(at(50.0 + 89.999)), Unsolved::Unreachable);
        assert_eq!(rig.k.inverse(&at(500.0), &mut joints), Ok(Solved::Regular));
        // Links of equal length fold back onto the axis: joint 0 is undetermined, and stays.
        rig.set(&[("scarakins.D4", 340.0), ("scarakins.D6", 0.0)]);
        let mut joints = [33.0, 10.0, 0., 0., 0., 0.];
        assert_eq!(rig.k.inverse(&at(0.0), &mut joints), Ok(Solved::Singular));
        close(&joints[..2], &[33.0, 180.0], 1e-9);
        for (pin, value) in [("D2", 0.0), ("D4", -1.0), ("D1", f64::NAN), ("D6", f64::INFINITY)] {
            let rig = Rig::new::<Scarakins>(&[]);
            rig.bench.set(&format!("scarakins.{pin}"), value);
            assert_eq!(rig.no_joints(at(500.0)), Unsolved::Geometry);
            assert_eq!(rig.no_pose(&[0.0; 6]), Unsolved::Geometry);
        }
    }

    #[test]
    fn turns_go_on() {
        let rig = Rig::new::<Scarakins>(&[]);
        let mut joints = [0., 90., 0., 0., 0., 0.];
        for c in 0..800 {
            let pose = [300., 0., 450., 0., 0., f64::from(c), 0., 0., 0.];
            let before = joints;
            rig.k.inverse(&pose, &mut joints).unwrap();
            if c > 0 {
                close(&joints, &before, 2.0);
            }
            let mut again = pose;
            rig.k.forward(&joints, &mut again).unwrap();
            close(&again, &pose, 1e-9);
        }
    }
}

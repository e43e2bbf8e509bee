//! `pumakins`.

use crate::{
    arms::arm::{Arm, Lengths},
    model::{are_lengths, is_finite},
    names::{example, names},
    switch::{COORDINATES, SPARM, Switched},
};
use hal_component::{Builder, Error, In, abi::ArgSpec, pins};

const DOC: &str = concat!(
    "\
Kinematics of an arm of six joints such as the Puma 560, solved in closed form.

All joints turn, in degrees; with all at 0 the upper arm lies along X and the forearm hangs down. The
pose is the tool's tip X Y Z and how it is turned: roll A, pitch B, yaw C about the fixed axes. Of up
to eight ways to reach a pose the one nearest to where the joints are is taken, turns included
(Pieper, The Kinematics of Manipulators under Computer Control, 1968; Craig, Introduction to
Robotics, section 4.6). With a straight wrist joint 3 stays and joint 5 turns: a singular place, as
is a stretched or folded elbow, or a wrist above the base. What the arm does not reach is refused.
A2 and D4 must be above 0.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "pumakins",
        6,
        "setp pumakins.D6 100\n",
        "motion.move x=300 y=100 z=-400 velocity=20 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[&COORDINATES.or("XYZABC"), &SPARM];

names! {
    DOC, ARGS, create;
    /// `loadrt pumakins`.
    Pumakins = "pumakins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    Switched::offer_six(b, |b| Pins::make(b, "pumakins"))
}

pins! {
    /// Lengths of the arm.
    struct Pins {
        /// Length of the upper arm, from the axis of joint 1 to that of joint 2, in units; above 0.
        a2: In<f64> = "A2", 300.0;
        /// Distance from the axis of joint 2 to that of joint 3, which is the forearm's, in units.
        a3: In<f64> = "A3", 50.0;
        /// Lateral offset of the upper arm from the axis of joint 0, in units.
        d3: In<f64> = "D3", 70.0;
        /// Length of the forearm, up to the middle of the wrist, in units; above 0.
        d4: In<f64> = "D4", 400.0;
        /// Distance from the middle of the wrist to the tool tip, in units.
        d6: In<f64> = "D6", 70.0;
    }
}

impl Lengths for Pins {
    fn arm(&self) -> Option<Arm> {
        let [a2, a3, d3, d4, d6] = [&self.a2, &self.a3, &self.d3, &self.d4, &self.d6].map(In::get);
        (are_lengths(&[a2, d4]) && is_finite(&[a3, d3, d6])).then_some(Arm {
            a1: 0.0,
            a2,
            a3,
            d1: 0.0,
            d3,
            d4,
            d6,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};
    use hal_component::{Solved, Unsolved};

    pub(crate) const SPACE: Space<'static> = Space {
        size: 700.0,
        joints: &[Joint::rotary(180.0); 6],
        letters: &[0, 1, 2, 3, 4, 5],
        abc: true,
        least: 3900,
        ..Space::DEFAULT
    };

    #[test]
    fn both_ways() {
        serial::<Pumakins>(&[], &SPACE);
        let set = &[("pumakins.A3", -20.0), ("pumakins.D3", 0.0), ("pumakins.D6", -10.0)];
        serial::<Pumakins>(&[], &Space { set, ..SPACE });
    }

    #[test]
    fn eight_ways() {
        let rig = Rig::new::<Pumakins>(&[]);
        let pose = rig.pose(&[10., -60., 40., 50., 60., 70.]);
        let ways = rig.ways(&pose);
        assert_eq!(ways.len(), 8);
        for (i, way) in ways.iter().enumerate() {
            let apart = SPACE.apart(&rig.pose(way), &pose);
            assert!(apart.iter().all(|a| a.abs() < 1e-12), "{way:?}");
            for other in &ways[..i] {
                let far = |(a, b): (&f64, &f64)| libm::remainder(a - b, 360.0).abs() > 1e-3;
                assert!(way.iter().zip(other).any(far), "{way:?} twice");
            }
        }
    }

    #[test]
    fn singular_places() {
        let rig = Rig::new::<Pumakins>(&[]);
        // Straight wrist: joint 3 stays, joint 5 turns instead.
        let pose = rig.pose(&[10., -50., 30., 25., 0., 30.]);
        let mut joints = [10., -50., 30., 11., 0.5, 30.];
        assert_eq!(rig.k.inverse(&pose, &mut joints), Ok(Solved::Singular));
        close(&joints, &[10., -50., 30., 11., 0., 44.], 1e-8);
        // Out of reach, and too close to the axis of the body.
        let far = |x: f64| [x, 0., 0., 180., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_joints(far(1e4)), Unsolved::Unreachable);
        assert_eq!(rig.no_joints(far(10.0)), Unsolved::Unreachable);
        for (pin, value) in [("A2", 0.0), ("D4", -1.0), ("D3", f64::NAN), ("D6", f64::INFINITY)] {
            let rig = Rig::new::<Pumakins>(&[]);
            rig.bench.set(&format!("pumakins.{pin}"), value);
            assert_eq!(rig.no_joints(far(300.0)), Unsolved::Geometry);
        }
    }

    #[test]
    fn turns_go_on() {
        let rig = Rig::new::<Pumakins>(&[]);
        let mut joints = [0., -50., 30., 10., 40., 0.];
        for n in 0..1000 {
            let mut wanted = joints;
            wanted[5] = f64::from(n);
            wanted[0] = f64::from(n) / 2.0;
            let pose = rig.pose(&wanted);
            rig.k.inverse(&pose, &mut joints).unwrap();
            close(&joints, &wanted, 1e-8);
        }
    }
}

//! `three21kins`.

use crate::{
    arms::arm::{Arm, Lengths},
    model::{are_lengths, is_finite},
    names::{example, names},
    switch::{COORDINATES, SPARM, Switched},
};
use hal_component::{Builder, Error, In, abi::ArgSpec, pins};

const DOC: &str = concat!(
    "\
Kinematics of an arm of six joints whose last three meet in the wrist, solved in closed form.

All joints turn, in degrees. The lengths are Denavit and Hartenberg's, in the form of Craig
(Introduction to Robotics, sections 3.4 and 4.6): D2 and D3 together, and A1, A2, A3, D1, D4, D6. With
all joints at 0 the upper arm lies along X and the forearm hangs down. The pose is the tool's tip
X Y Z and how it is turned: roll A, pitch B, yaw C about the fixed axes. Of up to eight ways to reach
a pose the one nearest to where the joints are is taken. With a straight wrist, a stretched or
folded elbow, or the wrist above the base it is at a singular place; what it does not reach is
refused. A2 must be above 0, and A3 and D4 may not both be 0.

In types 1 and 2 every joint is an axis; `motion.switchkins-type` says which type is in force.",
    example!(
        "three21kins",
        6,
        "setp three21kins.D6 50\n",
        "motion.move x=300 y=50 z=-100 velocity=20 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

const ARGS: &[&ArgSpec] = &[&COORDINATES.or("XYZABC"), &SPARM];

names! {
    DOC, ARGS, create;
    /// `loadrt three21kins`.
    Three21kins = "three21kins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    Switched::offer_six(b, |b| Pins::make(b, "three21kins"))
}

pins! {
    /// Lengths of the arm.
    struct Pins {
        /// Distance from the axis of joint 0 to that of joint 1, in units.
        a1: In<f64> = "A1", 64.2;
        /// Length of the upper arm, from the axis of joint 1 to that of joint 2, in units; above 0.
        a2: In<f64> = "A2", 305.0;
        /// Distance from the axis of joint 2 to that of joint 3, which is the forearm's, in units.
        a3: In<f64> = "A3", 0.0;
        /// Height of the axis of joint 1, in units.
        d1: In<f64> = "D1", 169.77;
        /// Lateral offset of the upper arm from the axis of joint 0, in units.
        d2: In<f64> = "D2", 0.0;
        /// Lateral offset of the forearm from the upper arm, in units.
        d3: In<f64> = "D3", -6.25;
        /// Length of the forearm, up to the middle of the wrist, in units.
        d4: In<f64> = "D4", 223.63;
        /// Distance from the middle of the wrist to the tool tip, in units.
        d6: In<f64> = "D6", 36.5;
    }
}

impl Lengths for Pins {
    fn arm(&self) -> Option<Arm> {
        let [a1, a2, a3] = [&self.a1, &self.a2, &self.a3].map(In::get);
        let [d1, d2, d3, d4, d6] = [&self.d1, &self.d2, &self.d3, &self.d4, &self.d6].map(In::get);
        let fore = libm::hypot(a3, d4);
        (are_lengths(&[a2, fore]) && is_finite(&[a1, d1, d2, d3, d6])).then_some(Arm {
            a1,
            a2,
            a3,
            d1,
            d3: d2 + d3,
            d4,
            d6,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, serial};

    const SPACE: Space<'static> = Space {
        size: 600.0,
        joints: &[Joint::rotary(180.0); 6],
        letters: &[0, 1, 2, 3, 4, 5],
        abc: true,
        least: 3900,
        ..Space::DEFAULT
    };

    #[test]
    fn both_ways() {
        serial::<Three21kins>(&[], &SPACE);
        let set = &[("three21kins.A3", 30.0), ("three21kins.D2", 20.0)];
        serial::<Three21kins>(&[], &Space { set, ..SPACE });
    }

    #[test]
    fn the_lengths_are_where_they_should() {
        let rig = Rig::new::<Three21kins>(&[]);
        crate::testing::close(
            &rig.pose(&[0.0; 6])[..3],
            &[64.2 + 305.0, -6.25, 169.77 - 223.63 - 36.5],
            1e-9,
        );
        assert_eq!(rig.ways(&rig.pose(&[10., -60., 40., 50., 60., 70.])).len(), 8);
    }
}

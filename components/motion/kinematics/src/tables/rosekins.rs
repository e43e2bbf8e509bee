//! `rosekins`.

use crate::{
    model::{Found, Joints, Model, Service},
    names::{example, names},
    rotation::{is_straight, near},
};
use hal_component::{Builder, Error, Out, Pose, Solved, pins};
use libm::{atan2, cos, hypot, round, sin};

const DOC: &str = concat!(
    "\
Kinematics of a rose engine: a lathe whose work turns under a tool that goes out and in.

Joint 0 is the distance of the tool from the spindle's axis, joint 1 its place along the axis, joint
2 the angle of the spindle in degrees (polar coordinates). X Y is the tool's place across the work,
Z along it. The spindle goes on from where it is, whole turns included, the shorter way round. On the
axis the direction is any: the spindle stays, and the place is singular. It has no functions; load it
before `motmod`.",
    example!(
        "rosekins",
        3,
        "",
        "motion.jog joint=0 velocity=50 position=20\nrun 1s\n\
         motion.move x=0 y=20 velocity=5 --wait\nshow pin joint.*.pos-cmd rosekins.*\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt rosekins`.
    Rosekins = "rosekins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let pins = Pins::make(b, "rosekins")?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Last commanded position of the spindle.
    struct Pins {
        /// Number of turns of the spindle, rounded to an integer.
        revolutions: Out<f64> = "revolutions", 0.0;
        /// Angle of the spindle within a turn, in degrees, -180 to 180.
        theta: Out<f64> = "theta_degrees", 0.0;
        /// Angle of the spindle including full turns, in degrees.
        bigtheta: Out<f64> = "bigtheta_degrees", 0.0;
    }
}

impl Model for Pins {
    type Geometry = ();

    fn joints(&self) -> usize {
        3
    }

    fn geometry(&self) -> Option<()> {
        Some(())
    }

    fn forward(&self, (): &(), joints: &Joints, guess: &Pose) -> Found<Pose> {
        let angle = joints[2].to_radians();
        let mut pose = *guess;
        pose[0] = joints[0] * cos(angle);
        pose[1] = joints[0] * sin(angle);
        pose[2] = joints[1];
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, (): &(), pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut joints = *guess;
        let out = hypot(pose[0], pose[1]);
        joints[0] = out;
        joints[1] = pose[2];
        if out > 0.0 {
            joints[2] = near(atan2(pose[1], pose[0]).to_degrees(), guess[2]);
        }
        let turns = round(joints[2] / 360.0);
        self.revolutions.set(turns);
        self.theta.set(joints[2] - 360.0 * turns);
        self.bigtheta.set(joints[2]);
        let solved = if is_straight(out) { Solved::Singular } else { Solved::Regular };
        Ok((joints, solved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};

    #[test]
    fn both_ways() {
        let joints = [Joint::linear_from(0.01, 100.0), Joint::linear(100.0), Joint::rotary(7200.0)];
        let letters = &[0, 1, 2];
        serial::<Rosekins>(&[], &Space { size: 100.0, joints: &joints, letters, ..Space::DEFAULT });
    }

    #[test]
    fn turns_go_on() {
        let rig = Rig::new::<Rosekins>(&[]);
        let mut joints = [0.0; 3];
        for n in 0..=40_i32 {
            let angle = f64::from(n * 20).to_radians();
            let pose = [angle.cos(), angle.sin(), 3., 0., 0., 0., 0., 0., 0.];
            rig.k.inverse(&pose, &mut joints).unwrap();
            close(&joints, &[1.0, 3.0, f64::from(n * 20)], 1e-9);
        }
        let shown =
            ["revolutions", "theta_degrees", "bigtheta_degrees"].map(|p| format!("rosekins.{p}"));
        close(&shown.map(|p| rig.bench.get(&p)), &[2.0, 80.0, 800.0], 1e-9);
        assert_eq!(rig.k.inverse(&[0.0; 9], &mut joints), Ok(Solved::Singular));
        close(&joints, &[0.0, 0.0, 800.0], 1e-9);
    }
}

//! `tripodkins`.

use crate::{
    model::{Found, Joints, Model, Service, is_finite},
    names::{example, names},
    parallel::circles::meet,
    rotation::{Vector, is_straight},
};
use hal_component::{Builder, Error, Io, Pose, Solved, Unsolved, pins};
use libm::fabs;

const DOC: &str = concat!(
    "\
Kinematics of a point that hangs from, or stands on, three motors: the joints are its distances.

The motors are at (0, 0), (Bx, 0) and (Cx, Cy) in the plane Z = 0; joints 0 to 2 are the distances
of X Y Z from them, in units, 0 and above (Manolakis, Efficient solution of 3-D position estimation by
trilateration, 1996). Z is above 0, or below when it was there before. Distances that do not meet are
refused, and so are motors in a line; in the plane of the motors the machine is at a singular place.",
    example!(
        "tripodkins",
        3,
        "setp tripodkins.Bx 300\nsetp tripodkins.Cx 150\nsetp tripodkins.Cy 260\n",
        "motion.jog joint=0 velocity=90 position=250\nmotion.jog joint=1 velocity=90 position=250\n\
         motion.jog joint=2 velocity=90 position=250\nrun 5s\n\
         motion.move x=100 y=100 z=150 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt tripodkins`.
    Tripodkins = "tripodkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let pins = Pins::make(b, "tripodkins")?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Positions of the motors; the first one is at the origin.
    struct Pins {
        /// X of the second motor, in units; not 0.
        bx: Io<f64> = "Bx", 1.0;
        /// X of the third motor, in units.
        cx: Io<f64> = "Cx", 1.0;
        /// Y of the third motor, in units; not 0.
        cy: Io<f64> = "Cy", 1.0;
    }
}

impl Model for Pins {
    type Geometry = [Vector; 3];

    fn joints(&self) -> usize {
        3
    }

    fn geometry(&self) -> Option<[Vector; 3]> {
        let [bx, cx, cy] = [&self.bx, &self.cx, &self.cy].map(Io::get);
        let fits = is_finite(&[bx, cx, cy]) && bx != 0.0 && cy != 0.0;
        fits.then(|| [Vector::zeros(), Vector::new(bx, 0.0, 0.0), Vector::new(cx, cy, 0.0)])
    }

    fn forward(&self, motors: &[Vector; 3], joints: &Joints, guess: &Pose) -> Found<Pose> {
        let radii = [joints[0], joints[1], joints[2]];
        if radii.iter().any(|r| *r < 0.0) {
            return Err(Unsolved::Unreachable);
        }
        let ([point, _], solved) = meet(motors, radii)?;
        let mut pose = *guess;
        let height = fabs(point.z);
        (pose[0], pose[1]) = (point.x, point.y);
        pose[2] = if guess[2] < 0.0 { -height } else { height };
        Ok((pose, solved))
    }

    fn inverse(&self, motors: &[Vector; 3], pose: &Pose, guess: &Joints) -> Found<Joints> {
        let point = Vector::new(pose[0], pose[1], pose[2]);
        let mut joints = *guess;
        let mut size = 0.0;
        for (joint, motor) in joints.iter_mut().zip(motors) {
            *joint = (point - motor).norm();
            size += *joint;
        }
        let flat = is_straight(point.z / size);
        Ok((joints, if flat { Solved::Singular } else { Solved::Regular }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, parallel};

    const SET: &[(&str, f64)] =
        &[("tripodkins.Bx", 300.0), ("tripodkins.Cx", 120.0), ("tripodkins.Cy", -260.0)];

    #[test]
    fn both_ways() {
        let space = Space {
            size: 300.0,
            joints: &[Joint::linear_from(0.0, 600.0); 3],
            letters: &[0, 1, 2],
            set: SET,
            poses: &[(-300., 500.), (-500., 300.), (10., 400.)],
            least: 3990,
            ..Space::DEFAULT
        };
        parallel::<Tripodkins>(&[], &space);
        let below = [(-300., 500.), (-500., 300.), (-400., -10.)];
        parallel::<Tripodkins>(&[], &Space { poses: &below, ..space });
    }

    #[test]
    fn what_does_not_meet_is_refused() {
        let rig = Rig::new::<Tripodkins>(&[]);
        rig.set(SET);
        assert_eq!(rig.no_pose(&[10., 10., 10.]), Unsolved::Unreachable);
        assert_eq!(rig.no_pose(&[-200., 200., 200.]), Unsolved::Unreachable);
        for (pin, value) in [("Bx", 0.0), ("Cy", 0.0), ("Cx", f64::NAN)] {
            let rig = Rig::new::<Tripodkins>(&[]);
            rig.bench.set(&format!("tripodkins.{pin}"), value);
            assert_eq!(rig.no_pose(&[1., 1., 1.]), Unsolved::Geometry);
        }
        // Flat between the motors.
        let rig = Rig::new::<Tripodkins>(&[]);
        let mut pose = [0.0; 9];
        assert_eq!(rig.k.forward(&[1.0, 0.0, 1.0], &mut pose), Ok(Solved::Singular));
        assert_eq!(pose[..3], [1.0, 0.0, 0.0]);
    }
}

//! `lineardeltakins`.

use crate::{
    model::{Found, Joints, Model, Service, are_lengths, pass},
    names::{example, names},
    parallel::circles::{SIN_60, meet},
    rotation::{Vector, is_straight},
};
use hal_component::{Builder, Error, In, Pose, Solved, Unsolved, pins};
use libm::sqrt;

const DOC: &str = concat!(
    "\
Kinematics of a linear delta machine, such as a Rostock or Kossel printer.

Three carriages run on upright rails, and the tool hangs on rods below them.

(0, 0) is the middle. The rails stand on a circle of radius R, that of joint 0 at (0, R), the others
120 degrees on, counter-clockwise. Joints 0 to 2 are the heights of the carriages, joints 3 to 8 are
A B C U V W. The tool hangs below the carriages by rods of length L (Merlet, Parallel Robots, section
3.2; trilateration by Manolakis, 1996). Where a rod lies flat the machine is at a singular place;
what is farther from a rail than L is refused, and so are heights at which a rod would stand upright
the other way. R and L must be above 0.",
    example!(
        "lineardeltakins",
        3,
        "setp lineardeltakins.R 110\nsetp lineardeltakins.L 250\n",
        "motion.move x=30 y=20 --wait\nmotion.move z=-200 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt lineardeltakins`.
    Lineardeltakins = "lineardeltakins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let pins = Pins::make(b, "lineardeltakins")?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Lengths of the machine.
    struct Pins {
        /// Radius of the circle of the rods' upper ends with the tool in the middle, minus the radius of the circle of
        /// their lower ends at the tool, in units; above 0. A change takes effect at once on the joints or on the pose.
        r: In<f64> = "R", 130.25;
        /// Length of the rods, in units; above 0.
        l: In<f64> = "L", 269.0;
    }
}

/// Positions of the rails, and the length of the rods.
struct Delta {
    rails: [Vector; 3],
    rod: f64,
}

impl Model for Pins {
    type Geometry = Delta;

    fn joints(&self) -> usize {
        9
    }

    fn geometry(&self) -> Option<Delta> {
        let (r, rod) = (self.r.get(), self.l.get());
        let aside = r * SIN_60;
        are_lengths(&[r, rod]).then(|| Delta {
            rails: [
                Vector::new(0.0, r, 0.0),
                Vector::new(-aside, -0.5 * r, 0.0),
                Vector::new(aside, -0.5 * r, 0.0),
            ],
            rod,
        })
    }

    fn forward(&self, g: &Delta, joints: &Joints, _: &Pose) -> Found<Pose> {
        let mut carriages = g.rails;
        for (carriage, joint) in carriages.iter_mut().zip(joints) {
            carriage.z = *joint;
        }
        let ([above, below], solved) = meet(&carriages, [g.rod; 3])?;
        let point = if below.z < above.z { below } else { above };
        if carriages.iter().any(|c| c.z < point.z) {
            return Err(Unsolved::Unreachable);
        }
        let mut pose = [0.0; 9];
        (pose[0], pose[1], pose[2]) = (point.x, point.y, point.z);
        pass(joints, 3, &mut pose, 3, 6);
        Ok((pose, solved))
    }

    fn inverse(&self, g: &Delta, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut joints = *guess;
        let mut solved = Solved::Regular;
        for (joint, rail) in joints.iter_mut().zip(&g.rails) {
            let (x, y) = (pose[0] - rail.x, pose[1] - rail.y);
            let left = 1.0 - (x * x + y * y) / (g.rod * g.rod);
            let reaches = left >= 0.0;
            if !reaches {
                return Err(Unsolved::Unreachable);
            }
            let up = sqrt(left);
            if is_straight(up) {
                solved = Solved::Singular;
            }
            *joint = pose[2] + up * g.rod;
        }
        pass(pose, 3, &mut joints, 3, 6);
        Ok((joints, solved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, parallel};

    const UP: Joint = Joint::linear_from(0.0, 600.0);
    const LINE: Joint = Joint::linear(100.0);

    #[test]
    fn both_ways() {
        let line = (-100., 100.);
        let space = Space {
            size: 269.0,
            joints: &[UP, UP, UP, LINE, LINE, LINE, LINE, LINE, LINE],
            poses: &[
                (-140., 140.),
                (-140., 140.),
                (-100., 400.),
                line,
                line,
                line,
                line,
                line,
                line,
            ],
            least: 3300,
            has_gaps: true,
            ..Space::DEFAULT
        };
        parallel::<Lineardeltakins>(&[], &space);
    }

    #[test]
    fn the_edge_of_what_it_reaches() {
        let rig = Rig::new::<Lineardeltakins>(&[]);
        let up = (269.0_f64 * 269.0 - 130.25 * 130.25).sqrt();
        close(
            &rig.pose(&[300., 300., 300., 4., 5., 6., 7., 8., 9.]),
            &[0., 0., 300. - up, 4., 5., 6., 7., 8., 9.],
            1e-9,
        );
        let at = |x: f64, y: f64| [x, y, 0., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_joints(at(1000.0, 0.0)), Unsolved::Unreachable);
        let mut joints = [0.0; 9];
        let flat = at(0.0, 130.25 - 269.0);
        assert_eq!(rig.k.inverse(&flat, &mut joints), Ok(Solved::Singular));
        // Heights so far apart that the rods do not meet, or only with a carriage below the tool.
        let far = [100., 1000., 10., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_pose(&far), Unsolved::Unreachable);
        let steep = [0., 330., 330., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_pose(&steep), Unsolved::Unreachable);
        for (pin, value) in [("R", 0.0), ("L", -1.0), ("L", f64::NAN), ("R", f64::INFINITY)] {
            let rig = Rig::new::<Lineardeltakins>(&[]);
            rig.bench.set(&format!("lineardeltakins.{pin}"), value);
            assert_eq!(rig.no_joints(at(0.0, 0.0)), Unsolved::Geometry);
        }
    }
}

//! `rotarydeltakins`.

use crate::{
    model::{Found, Joints, Model, Service, are_lengths, pass},
    names::{example, names},
    parallel::circles::{SIN_60, meet, within_one},
    rotation::{Vector, is_straight, near},
};
use hal_component::{Builder, Error, In, Pose, Solution, Solved, Unsolved, Ways, pins};
use libm::{acos, atan2, cos, fabs, hypot, sin};

const DOC: &str = concat!(
    "\
Kinematics of a rotary delta machine: three legs with knees under a platform carry the tool.

Each motor on the platform swings a thigh up and down; shins run from the knees to the foot.

The motors stand on a circle of radius platformradius in the plane Z = 0, that of joint 0 towards
-Y, the others 120 degrees on, counter-clockwise. Joints 0 to 2 are the angles of the thighs in
degrees: 0 lies flat and outward, 90 hangs down; joints 3 to 8 are A B C U V W. The foot is below the
knees, and the knees are outside (Clavel, Delta, a fast robot with parallel geometry, 1988; Merlet,
Parallel Robots, section 3.2). Where a thigh and its shin are in one line the machine is at a singular
place; what the legs do not reach is refused. All lengths must be above 0.",
    example!(
        "rotarydeltakins",
        3,
        "setp rotarydeltakins.shinlength 16\n",
        "motion.move x=1 y=2 z=-12 velocity=2 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt rotarydeltakins`.
    Rotarydeltakins = "rotarydeltakins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let pins = Pins::make(b, "rotarydeltakins")?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Lengths of the machine.
    struct Pins {
        /// Radius of the circle of the motors, in units; above 0.
        platform: In<f64> = "platformradius", 10.0;
        /// Length of the thighs, from motor to knee, in units; above 0.
        thigh: In<f64> = "thighlength", 10.0;
        /// Length of the shins, from knee to foot, in units; above 0.
        shin: In<f64> = "shinlength", 14.0;
        /// Radius of the circle on which the shins meet the foot, in units; above 0.
        foot: In<f64> = "footradius", 6.0;
    }
}

/// Lengths in units; `radius` is that of the motors minus that of the foot.
struct Delta {
    radius: f64,
    thigh: f64,
    shin: f64,
}

/// Directions of the three legs.
const OUT: [(f64, f64); 3] = [(0.0, -1.0), (SIN_60, 0.5), (-SIN_60, 0.5)];

/// Returns the angle of a thigh in radians for a foot at a point, with the knee outside or inside, and whether the
/// thigh is in line with its shin.
fn thigh(
    g: &Delta,
    point: &Vector,
    out: (f64, f64),
    inside: bool,
) -> Result<(f64, bool), Unsolved> {
    // Coordinates seen along the motor's axis: outward, sideways and down.
    let ahead = point.x * out.0 + point.y * out.1 - g.radius;
    let aside = point.y * out.0 - point.x * out.1;
    let down = -point.z;
    let far = hypot(ahead, down);
    let square = ahead * ahead + aside * aside + down * down;
    let cosine = (g.thigh * g.thigh + square - g.shin * g.shin) / (2.0 * g.thigh * far);
    let reaches = fabs(cosine) <= 1.0 + 1e-12;
    if !reaches {
        return Err(Unsolved::Unreachable);
    }
    let open = acos(within_one(cosine));
    let open = if inside { -open } else { open };
    Ok((atan2(down, ahead) - open, is_straight(sin(open))))
}

impl Model for Pins {
    type Geometry = Delta;

    fn joints(&self) -> usize {
        9
    }

    fn geometry(&self) -> Option<Delta> {
        let [platform, thigh, shin, foot] =
            [&self.platform, &self.thigh, &self.shin, &self.foot].map(In::get);
        are_lengths(&[platform, thigh, shin, foot]).then_some(Delta {
            radius: platform - foot,
            thigh,
            shin,
        })
    }

    fn forward(&self, g: &Delta, joints: &Joints, _: &Pose) -> Found<Pose> {
        let knee = |angle: f64, out: (f64, f64)| {
            let angle = angle.to_radians();
            let far = g.radius + g.thigh * cos(angle);
            Vector::new(far * out.0, far * out.1, -g.thigh * sin(angle))
        };
        let [a, b, c] = OUT;
        let knees = [knee(joints[0], a), knee(joints[1], b), knee(joints[2], c)];
        let ([above, below], solved) = meet(&knees, [g.shin; 3])?;
        let point = if below.z < above.z { below } else { above };
        // The same angles must put the foot there with the knees outside.
        for (joint, out) in joints.iter().zip(OUT) {
            let (angle, in_line) = thigh(g, &point, out, false)?;
            let is = libm::remainder(joint - angle.to_degrees(), 360.0);
            if !in_line && fabs(is) > 1e-3 {
                return Err(Unsolved::Unreachable);
            }
        }
        let mut pose = [0.0; 9];
        (pose[0], pose[1], pose[2]) = (point.x, point.y, point.z);
        pass(joints, 3, &mut pose, 3, 6);
        Ok((pose, solved))
    }

    fn inverse(&self, g: &Delta, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let point = Vector::new(pose[0], pose[1], pose[2]);
        let mut joints = *guess;
        let mut solved = Solved::Regular;
        for ((joint, last), out) in joints.iter_mut().zip(guess).zip(OUT) {
            let (angle, in_line) = thigh(g, &point, out, false)?;
            *joint = near(angle.to_degrees(), *last);
            if in_line {
                solved = Solved::Singular;
            }
        }
        pass(pose, 3, &mut joints, 3, 6);
        Ok((joints, solved))
    }

    fn solutions(&self, g: &Delta, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let (first, solved) = self.inverse(g, pose, &[0.0; 16])?;
        let point = Vector::new(pose[0], pose[1], pose[2]);
        for n in 0..8_u32 {
            let mut joints = first;
            for (leg, (joint, out)) in joints.iter_mut().zip(OUT).enumerate() {
                let (angle, _) = thigh(g, &point, out, n >> leg & 1 == 1)?;
                *joint = near(angle.to_degrees(), 0.0);
            }
            ways.push(&joints);
        }
        Ok(solved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, parallel};

    const TURN: Joint = Joint::rotary(90.0);
    const LINE: Joint = Joint::linear(10.0);

    #[test]
    fn both_ways() {
        let line = (-10., 10.);
        let space = Space {
            size: 14.0,
            joints: &[TURN, TURN, TURN, LINE, LINE, LINE, LINE, LINE, LINE],
            poses: &[(-8., 8.), (-8., 8.), (-20., -6.), line, line, line, line, line, line],
            least: 3000,
            has_gaps: true,
            ..Space::DEFAULT
        };
        parallel::<Rotarydeltakins>(&[], &space);
    }

    #[test]
    fn its_legs() {
        let rig = Rig::new::<Rotarydeltakins>(&[]);
        // Thighs straight down, with the shins running to the foot below.
        let joints = [90., 90., 90., 4., 5., 6., 7., 8., 9.];
        let z = -10.0 - (14.0_f64 * 14.0 - 16.0).sqrt();
        close(&rig.pose(&joints), &[0., 0., z, 4., 5., 6., 7., 8., 9.], 1e-9);
        close(&rig.joints([0., 0., z, 0., 0., 0., 0., 0., 0.])[..3], &[90.0; 3], 1e-9);
        let pose = [1., 2., -12., 0., 0., 0., 0., 0., 0.];
        let ways = rig.ways(&pose);
        assert_eq!(ways.len(), 8);
        close(&ways[0], &rig.joints(pose)[..9], 1e-12);
        let far = [100., 0., 0., 0., 0., 0., 0., 0., 0.];
        assert_eq!(rig.no_joints(far), Unsolved::Unreachable);
        assert_eq!(rig.no_pose(&[170., 170., 170., 0., 0., 0., 0., 0., 0.]), Unsolved::Unreachable);
        for pin in ["platformradius", "thighlength", "shinlength", "footradius"] {
            for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                let rig = Rig::new::<Rotarydeltakins>(&[]);
                rig.bench.set(&format!("rotarydeltakins.{pin}"), value);
                assert_eq!(rig.no_joints(pose), Unsolved::Geometry);
            }
        }
    }
}

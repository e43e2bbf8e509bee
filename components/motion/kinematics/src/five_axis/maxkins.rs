//! `maxkins`.

use crate::{
    model::{Found, Joints, Model, Service, pass},
    names::{example, names},
    rotation::{Vector, about_z},
};
use hal_component::{Builder, Error, In, Io, Pose, Solved, pins};
use libm::{cos, sin};

const DOC: &str = concat!(
    "\
Kinematics of a mill with a tilting head B, a rotary table C, and U V W along the tool.

The head tilts about a pivot, `pivot-length` above the tool's tip, and the table turns under it.
Joints 0 to 2 are the places of X, Y and Z, joints 3 to 5 the angles A, B and C in degrees, joints 6
to 8 are U, V and W: W moves the tool along itself, U across, in the plane in which the head tilts.
The pose is the tool's tip on the work piece: the joints' place and what the head adds, turned with
the table (She and Chang, Design of a generic five-axis postprocessor, 2007). It has no functions;
load it before `motmod`.",
    example!(
        "maxkins",
        9,
        "setp maxkins.pivot-length 120\n",
        "motion.move x=10 b=30 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[], create;
    /// `loadrt maxkins`.
    Maxkins = "maxkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    let pins = Pins::make(b, "maxkins")?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Geometry of the machine.
    struct Pins {
        /// Distance from the pivot of the head to the tool tip, in units; may be 0 or negative. A change takes effect
        /// at once on the joints or on the pose.
        pivot: Io<f64> = "pivot-length", 0.666;
        /// TRUE: B and C count in the opposite direction.
        conventional: In<bool> = "conventional-directions", false;
    }
}

/// Pivot length in units, and the sign of the angles.
type Geometry = (f64, f64);

/// Returns the offset that the head adds to X, Y and Z.
fn head((pivot, sign): &Geometry, [b, u, v, w]: [f64; 4]) -> Vector {
    let b = (sign * b).to_radians();
    let (s, c) = (sin(b), cos(b));
    let length = pivot + w;
    Vector::new(length * s - u * c, -v, pivot - length * c - u * s)
}

impl Model for Pins {
    type Geometry = Geometry;

    fn joints(&self) -> usize {
        9
    }

    fn geometry(&self) -> Option<Geometry> {
        let pivot = self.pivot.get();
        let sign = if self.conventional.get() { -1.0 } else { 1.0 };
        crate::model::is_finite(&[pivot]).then_some((pivot, sign))
    }

    fn forward(&self, g: &Geometry, joints: &Joints, _: &Pose) -> Found<Pose> {
        let mut pose = [0.0; 9];
        pass(joints, 0, &mut pose, 0, 9);
        let place = Vector::new(joints[0], joints[1], joints[2])
            + head(g, [joints[4], joints[6], joints[7], joints[8]]);
        let tip = about_z((g.1 * joints[5]).to_radians()) * place;
        (pose[0], pose[1], pose[2]) = (tip.x, tip.y, tip.z);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, g: &Geometry, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut joints = *guess;
        pass(pose, 0, &mut joints, 0, 9);
        let tip = Vector::new(pose[0], pose[1], pose[2]);
        let place = about_z(-(g.1 * pose[5]).to_radians()) * tip
            - head(g, [pose[4], pose[6], pose[7], pose[8]]);
        (joints[0], joints[1], joints[2]) = (place.x, place.y, place.z);
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};

    #[test]
    fn both_ways() {
        let mut joints = [Joint::linear(500.0); 9];
        joints[3..6].fill(Joint::rotary(360.0));
        for set in ["0", "1"] {
            let set: &[(&str, f64)] =
                &[("maxkins.pivot-length", if set == "0" { 100.0 } else { -3.0 })];
            serial::<Maxkins>(&[], &Space { size: 1000.0, joints: &joints, set, ..Space::DEFAULT });
        }
    }

    #[test]
    fn the_tip_swings_about_the_pivot() {
        let rig = Rig::new::<Maxkins>(&[]);
        rig.bench.set("maxkins.pivot-length", 100.0);
        let tip = rig.pose(&[0., 0., 0., 0., 90., 0., 0., 0., 0.]);
        close(&tip[..3], &[100.0, 0.0, 100.0], 1e-12);
        rig.bench.set("maxkins.conventional-directions", true);
        let tip = rig.pose(&[0., 0., 0., 0., 90., 0., 0., 0., 0.]);
        close(&tip[..3], &[-100.0, 0.0, 100.0], 1e-12);
        // W is along the tool, U across it.
        rig.bench.set("maxkins.conventional-directions", false);
        let [still, w, u] = [[0., 0.], [0., 5.], [5., 0.]]
            .map(|[u, w]| rig.pose(&[0., 0., 0., 0., 30., 0., u, 0., w]));
        let way = |p: &Pose| [p[0] - still[0], p[2] - still[2]];
        let (w, u) = (way(&w), way(&u));
        close(&w, &[2.5, -5.0 * 0.75_f64.sqrt()], 1e-12);
        assert!((w[0] * u[0] + w[1] * u[1]).abs() < 1e-12, "{w:?} {u:?}");
    }
}

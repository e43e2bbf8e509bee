//! `matrixkins`.

use crate::{
    instances::{COUNT, NAMES, prefixes},
    model::{Found, Joints, Model, Service, is_finite, pass},
    names::{example, names},
    rotation::{Matrix, Vector},
};
use hal_component::{Builder, Error, In, Out, Pose, Solved, pins};
use libm::fabs;

const DOC: &str = concat!(
    "\
Kinematics of a machine of three axes that are not quite square, calibrated by a matrix.

Joints 0 to 2 are the matrix times X Y Z; the pose is found with its inverse. C_xy is how far joint 0
must go for one unit of Y, and so on: 0.001 takes off a millimetre in a metre. Joints 3 to 8 are
A B C U V W. A matrix that has no inverse is refused.",
    example!(
        "matrixkins",
        3,
        "setp matrixkins.C_xy 0.001\n",
        "motion.move x=100 y=100 --wait\nshow pin joint.*.pos-cmd\n"
    )
);

names! {
    DOC, &[&COUNT, &NAMES], create;
    /// `loadrt matrixkins`.
    Matrixkins = "matrixkins";
}

fn create(b: &mut Builder<'_>) -> Result<(), Error> {
    for prefix in prefixes(b, "matrixkins")? {
        let _: Out<bool> = b.item(&format!("{prefix}.dummy"), "Always TRUE.", true)?;
    }
    let pins = Pins::make(b, "matrixkins")?;
    b.offer_kinematics(Service(pins))
}

pins! {
    /// Coefficients of the joints.
    struct Pins {
        /// Travel of joint 0 per unit of X.
        xx: In<f64> = "C_xx", 1.0;
        /// Travel of joint 0 per unit of Y.
        xy: In<f64> = "C_xy", 0.0;
        /// Travel of joint 0 per unit of Z.
        xz: In<f64> = "C_xz", 0.0;
        /// Travel of joint 1 per unit of X.
        yx: In<f64> = "C_yx", 0.0;
        /// Travel of joint 1 per unit of Y.
        yy: In<f64> = "C_yy", 1.0;
        /// Travel of joint 1 per unit of Z.
        yz: In<f64> = "C_yz", 0.0;
        /// Travel of joint 2 per unit of X.
        zx: In<f64> = "C_zx", 0.0;
        /// Travel of joint 2 per unit of Y.
        zy: In<f64> = "C_zy", 0.0;
        /// Travel of joint 2 per unit of Z.
        zz: In<f64> = "C_zz", 1.0;
    }
}

/// Matrix and its inverse.
struct Geometry {
    to_joints: Matrix,
    to_axes: Matrix,
}

impl Model for Pins {
    type Geometry = Geometry;

    fn joints(&self) -> usize {
        9
    }

    fn geometry(&self) -> Option<Geometry> {
        let rows = [
            [&self.xx, &self.xy, &self.xz].map(In::get),
            [&self.yx, &self.yy, &self.yz].map(In::get),
            [&self.zx, &self.zy, &self.zz].map(In::get),
        ];
        if !rows.iter().all(|r| is_finite(r)) {
            return None;
        }
        let [x, y, z] = rows.map(|r| Vector::from(r).transpose());
        let to_joints = Matrix::from_rows(&[x, y, z]);
        // A matrix whose columns span no volume has no inverse.
        let room = x.norm() * y.norm() * z.norm();
        let fills = fabs(to_joints.determinant()) > 1e-9 * room;
        if !fills {
            return None;
        }
        Some(Geometry { to_joints, to_axes: to_joints.try_inverse()? })
    }

    fn forward(&self, g: &Geometry, joints: &Joints, _: &Pose) -> Found<Pose> {
        let mut pose = [0.0; 9];
        pass(joints, 0, &mut pose, 0, 9);
        let place = g.to_axes * Vector::new(joints[0], joints[1], joints[2]);
        (pose[0], pose[1], pose[2]) = (place.x, place.y, place.z);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, g: &Geometry, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut joints = *guess;
        pass(pose, 0, &mut joints, 0, 9);
        let place = g.to_joints * Vector::new(pose[0], pose[1], pose[2]);
        (joints[0], joints[1], joints[2]) = (place.x, place.y, place.z);
        Ok((joints, Solved::Regular))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Joint, Rig, Space, close, serial};
    use hal_component::Unsolved;

    #[test]
    fn both_ways() {
        let joints = [Joint::linear(500.0); 9];
        let space = Space { size: 1000.0, joints: &joints, ..Space::DEFAULT };
        serial::<Matrixkins>(&[], &space);
        let set = &[
            ("matrixkins.C_xy", 0.2),
            ("matrixkins.C_yz", -0.3),
            ("matrixkins.C_zx", 0.1),
            ("matrixkins.C_zz", 1.4),
        ];
        serial::<Matrixkins>(&[], &Space { set, ..space });
    }

    #[test]
    fn its_matrix() {
        let rig = Rig::new::<Matrixkins>(&[]);
        rig.set(&[("matrixkins.C_xy", 0.5), ("matrixkins.C_zz", 2.0)]);
        let pose = [1., 2., 3., 4., 5., 6., 7., 8., 9.];
        close(&rig.joints(pose)[..9], &[2., 2., 6., 4., 5., 6., 7., 8., 9.], 0.0);
        rig.set(&[("matrixkins.C_zz", 0.0)]);
        assert_eq!(rig.no_joints(pose), Unsolved::Geometry);
        assert_eq!(rig.no_pose(&pose), Unsolved::Geometry);
    }
}

//! Realtime. Machines with one joint per axis letter whose rotary axes displace the tool tip.

use crate::{
    letters::Letters,
    model::{Found, Joints, Model},
    rotation::Vector,
};
use hal_component::{Pose, Solved, Touch, Uses};

/// Position of the tool tip on the workpiece for given axis positions.
pub(crate) trait Tip: Touch + Send + Sync + 'static {
    /// Lengths of the machine.
    type Geometry;

    /// Reads the lengths from the pins. Returns `None` if they are invalid.
    fn geometry(&self) -> Option<Self::Geometry>;

    /// Converts positions of the linear axes to the tip position; the other letters hold the rotation.
    fn to_work(&self, g: &Self::Geometry, place: Vector, letters: &Pose) -> Vector;

    /// Converts the tip position to positions of the linear axes.
    fn to_machine(&self, g: &Self::Geometry, tip: Vector, letters: &Pose) -> Vector;
}

/// Machine with a tip and the letters of its joints.
#[derive(Debug)]
pub(crate) struct Lettered<T> {
    pub(crate) tip: T,
    pub(crate) letters: Letters,
}

impl<T: Touch> Touch for Lettered<T> {
    fn touch(&self, uses: &mut Uses) {
        self.tip.touch(uses);
    }
}

impl<T: Tip> Model for Lettered<T> {
    type Geometry = T::Geometry;

    fn joints(&self) -> usize {
        self.letters.joints()
    }

    fn joint_of(&self, letter: usize) -> Option<usize> {
        self.letters.joint_of(letter)
    }

    fn geometry(&self) -> Option<T::Geometry> {
        self.tip.geometry()
    }

    fn forward(&self, g: &T::Geometry, joints: &Joints, guess: &Pose) -> Found<Pose> {
        let mut pose = self.letters.forward(joints, guess);
        let tip = self.tip.to_work(g, Vector::new(pose[0], pose[1], pose[2]), &pose);
        (pose[0], pose[1], pose[2]) = (tip.x, tip.y, tip.z);
        Ok((pose, Solved::Regular))
    }

    fn inverse(&self, g: &T::Geometry, pose: &Pose, guess: &Joints) -> Found<Joints> {
        let mut place = *pose;
        let at = self.tip.to_machine(g, Vector::new(pose[0], pose[1], pose[2]), pose);
        (place[0], place[1], place[2]) = (at.x, at.y, at.z);
        Ok((self.letters.inverse(&place, guess), Solved::Regular))
    }
}

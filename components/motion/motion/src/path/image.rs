//! The planner's image of the kinematics.

use crate::setup::MAX_JOINTS;
use hal_component::{KinematicsKind, KinematicsRef};
use hal_trajectory::{AXES, Joints, Kinematics, Pose};
use std::cell::Cell;

/// Kinematics for the planner. Each solution is the first guess for the next one, so that iterative solvers keep their
/// branch along the path.
#[derive(Clone, Debug)]
pub(crate) struct Image {
    kinematics: KinematicsRef,
    guess: Cell<Joints>,
    /// Axis of each joint, if every joint follows one axis.
    axes: Option<[Option<usize>; MAX_JOINTS]>,
}

impl Image {
    /// Image that begins at these joint positions.
    pub(crate) fn new(kinematics: KinematicsRef, places: &Joints) -> Self {
        let identity = kinematics.kind() == KinematicsKind::Identity;
        let axes = identity.then(|| axes_of_joints(&kinematics));
        Self { kinematics, guess: Cell::new(*places), axes }
    }
}

/// Returns the axis that each joint follows: the one whose unit moves it by a unit.
pub(crate) fn axes_of_joints(kinematics: &KinematicsRef) -> [Option<usize>; MAX_JOINTS] {
    let mut axes = [None; MAX_JOINTS];
    let mut zero = [0.0; MAX_JOINTS];
    if kinematics.inverse(&[0.0; AXES], &mut zero).is_err() {
        return axes;
    }
    for axis in 0..AXES {
        let mut pose = [0.0; AXES];
        if let Some(p) = pose.get_mut(axis) {
            *p = 1.0;
        }
        let mut there = zero;
        if kinematics.inverse(&pose, &mut there).is_err() {
            continue;
        }
        for (slot, (a, b)) in axes.iter_mut().zip(zero.iter().zip(&there)) {
            if (b - a).abs() > 0.5 {
                *slot = Some(axis);
            }
        }
    }
    axes
}

impl Kinematics for Image {
    fn inverse(&self, pose: &Pose) -> Result<Joints, usize> {
        let mut joints = self.guess.get();
        if self.kinematics.inverse(&pose.0, &mut joints).is_err() {
            return Err(0);
        }
        match joints.iter().position(|p| !p.is_finite()) {
            Some(joint) => Err(joint),
            None => {
                self.guess.set(joints);
                Ok(joints)
            }
        }
    }

    fn axes_of_joints(&self) -> Option<[Option<usize>; MAX_JOINTS]> {
        self.axes
    }
}

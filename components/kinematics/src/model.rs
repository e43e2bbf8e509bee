//! Realtime. What all kinematics here have in common: a model, and the service that asks it.

use hal_component::{
    Kinematics, KinematicsKind, Pose, Solution, Solved, Touch, Unsolved, Uses, Ways,
};

/// The most joints there can be.
pub(crate) const MAX_JOINTS: usize = 16;

/// Joint positions; those beyond a machine's joints mean nothing.
pub(crate) type Joints = [f64; MAX_JOINTS];

/// An answer, and whether it is at a singular place.
pub(crate) type Found<T> = Result<(T, Solved), Unsolved>;

/// How the joints of one kind of machine and poses follow each other.
pub(crate) trait Model: Touch + Send + Sync + 'static {
    /// Its lengths and points, read once for each question.
    type Geometry;

    /// How many joints it has.
    fn joints(&self) -> usize;

    /// The first joint that follows a letter, where joints follow letters.
    fn joint_of(&self, _: usize) -> Option<usize> {
        None
    }

    /// The lengths as the pins have them now; none when they make no sense.
    fn geometry(&self) -> Option<Self::Geometry>;

    /// From joints to a pose; letters that nothing moves stay as in the guess.
    fn forward(&self, g: &Self::Geometry, joints: &Joints, guess: &Pose) -> Found<Pose>;

    /// From a pose to joints, near the guess where there is a choice.
    fn inverse(&self, g: &Self::Geometry, pose: &Pose, guess: &Joints) -> Found<Joints>;

    /// All joints that make a pose.
    fn solutions(&self, g: &Self::Geometry, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let (joints, solved) = self.inverse(g, pose, &[0.0; MAX_JOINTS])?;
        ways.push(&joints);
        Ok(solved)
    }
}

/// Asks a model. What goes in and out is finite, and a refusal leaves everything as it was.
pub(crate) fn forward<M: Model>(m: &M, joints: &[f64], pose: &mut Pose) -> Solution {
    let joints = gather(joints, m.joints())?;
    if !is_finite(pose) {
        return Err(Unsolved::NoNumber);
    }
    let g = m.geometry().ok_or(Unsolved::Geometry)?;
    let (found, solved) = m.forward(&g, &joints, pose)?;
    if !is_finite(&found) {
        return Err(Unsolved::Undetermined);
    }
    *pose = found;
    Ok(solved)
}

/// As [`forward`].
pub(crate) fn inverse<M: Model>(m: &M, pose: &Pose, joints: &mut [f64]) -> Solution {
    if !is_finite(pose) {
        return Err(Unsolved::NoNumber);
    }
    let guess = gather(joints, m.joints())?;
    let g = m.geometry().ok_or(Unsolved::Geometry)?;
    let (found, solved) = m.inverse(&g, pose, &guess)?;
    if !is_finite(&found) {
        return Err(Unsolved::Undetermined);
    }
    for (to, from) in joints.iter_mut().zip(found).take(m.joints()) {
        *to = from;
    }
    Ok(solved)
}

/// As [`forward`].
pub(crate) fn solutions<M: Model>(m: &M, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
    if !is_finite(pose) {
        return Err(Unsolved::NoNumber);
    }
    let g = m.geometry().ok_or(Unsolved::Geometry)?;
    m.solutions(&g, pose, ways)
}

fn gather(joints: &[f64], n: usize) -> Result<Joints, Unsolved> {
    let mut out = [0.0; MAX_JOINTS];
    let Some(given) = joints.get(..n) else {
        return Err(Unsolved::NoNumber);
    };
    if !is_finite(given) {
        return Err(Unsolved::NoNumber);
    }
    for (to, from) in out.iter_mut().zip(given) {
        *to = *from;
    }
    Ok(out)
}

/// Every number is one, and not beyond what squares and products of a few can hold.
pub(crate) fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite() && libm::fabs(*x) < MOST)
}

/// All lengths are finite and above 0.
pub(crate) fn are_lengths(lengths: &[f64]) -> bool {
    is_finite(lengths) && lengths.iter().all(|l| *l > LEAST)
}

/// No machine is larger.
const MOST: f64 = 1e30;
/// No part of a machine is smaller.
const LEAST: f64 = 1e-30;

/// The service of kinematics of one type.
#[derive(Debug)]
pub(crate) struct Service<M>(pub(crate) M);

impl<M: Touch> Touch for Service<M> {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

impl<M: Model> Kinematics for Service<M> {
    fn joints(&self) -> usize {
        self.0.joints()
    }

    fn kind(&self) -> KinematicsKind {
        KinematicsKind::Both
    }

    fn joint_of(&self, letter: usize) -> Option<usize> {
        self.0.joint_of(letter)
    }

    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        forward(&self.0, joints, pose)
    }

    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        inverse(&self.0, pose, joints)
    }

    fn solutions(&self, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        solutions(&self.0, pose, ways)
    }
}

/// Copies `n` numbers from one place of a list to one of another: what stands beside a machine
/// passes as it is.
pub(crate) fn pass(from: &[f64], at: usize, to: &mut [f64], place: usize, n: usize) {
    for (to, from) in to.iter_mut().skip(place).zip(from.iter().skip(at)).take(n) {
        *to = *from;
    }
}

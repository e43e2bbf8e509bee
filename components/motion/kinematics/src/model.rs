//! Realtime. Interface shared by all kinematics of this crate: a model, and the service that queries it.

use hal_component::{
    Kinematics, KinematicsKind, Pose, Solution, Solved, Touch, Unsolved, Uses, Ways,
};

/// Maximum number of joints.
pub(crate) const MAX_JOINTS: usize = 16;

/// Joint positions; entries beyond the machine's joints are unused.
pub(crate) type Joints = [f64; MAX_JOINTS];

/// Solution, and whether it is singular; or the reason why there is none.
pub(crate) type Found<T> = Result<(T, Solved), Unsolved>;

/// Relation between joints and pose of one kind of machine.
pub(crate) trait Model: Touch + Send + Sync + 'static {
    /// Lengths and points of the machine, read once per query.
    type Geometry;

    /// Returns the number of joints.
    fn joints(&self) -> usize;

    /// Returns the first joint that follows a letter, if joints follow letters.
    fn joint_of(&self, _: usize) -> Option<usize> {
        None
    }

    /// Reads the lengths from the pins. Returns `None` if they are invalid.
    fn geometry(&self) -> Option<Self::Geometry>;

    /// Returns the pose of these joints; letters that no joint moves keep the guess.
    fn forward(&self, g: &Self::Geometry, joints: &Joints, guess: &Pose) -> Found<Pose>;

    /// Returns the joints for a pose; of several solutions, one near the guess.
    fn inverse(&self, g: &Self::Geometry, pose: &Pose, guess: &Joints) -> Found<Joints>;

    /// Collects all joint positions that produce a pose.
    fn solutions(&self, g: &Self::Geometry, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let (joints, solved) = self.inverse(g, pose, &[0.0; MAX_JOINTS])?;
        ways.push(&joints);
        Ok(solved)
    }
}

/// Queries a model for a pose. Inputs and outputs must be finite; an error leaves `pose` unchanged.
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

/// Queries a model for joints, as [`forward`] does for a pose.
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

/// Queries a model for all solutions, with the checks of [`forward`].
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

/// Returns whether every number is finite and small enough that squares and products of a few do not overflow.
pub(crate) fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite() && libm::fabs(*x) < MAX)
}

/// Returns whether all lengths are finite and above 0.
pub(crate) fn are_lengths(lengths: &[f64]) -> bool {
    is_finite(lengths) && lengths.iter().all(|l| *l > LEAST)
}

/// Largest magnitude of a number.
const MAX: f64 = 1e30;
/// Smallest length.
const LEAST: f64 = 1e-30;

/// Kinematics service of one model.
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

/// Copies `n` numbers from index `at` of one slice to index `place` of another, for axes that pass through unchanged.
pub(crate) fn pass(from: &[f64], at: usize, to: &mut [f64], place: usize, n: usize) {
    for (to, from) in to.iter_mut().skip(place).zip(from.iter().skip(at)).take(n) {
        *to = *from;
    }
}

//! The service `kinematics`: conversion between joint positions and poses.

use crate::{
    Solution, Touch, Unsolved, Uses, Ways,
    abi::{self, Status, Use},
    service::Found,
    solved::{solution, status},
};
use core::ffi::c_void;

/// Pose x y z a b c u v w, in the machine's units and degrees.
pub type Pose = [f64; 9];

/// Directions in which kinematics can convert.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum KinematicsKind {
    /// Joints are axes.
    Identity,
    /// Only from joint positions to a pose.
    ForwardOnly,
    /// Only from a pose to joint positions.
    InverseOnly,
    /// Both directions.
    Both,
}

/// Kinematics that a component offers. They must be reentrant, allocate nothing and take no locks.
pub trait Kinematics: Touch + Send + Sync + 'static {
    /// Returns the number of joints.
    fn joints(&self) -> usize;
    /// Returns the directions in which the kinematics can convert.
    fn kind(&self) -> KinematicsKind;
    /// Returns the first joint of each letter (x y z a b c u v w).
    fn joint_of(&self, letter: usize) -> Option<usize>;
    /// Computes a pose from joint positions. On entry, `pose` holds the last pose as a first guess.
    /// It stays unchanged if there is no solution.
    ///
    /// # Errors
    /// No pose has these joint positions, or none is found.
    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution;
    /// Computes joint positions from a pose. On entry, `joints` holds the last positions as a first
    /// guess. They stay unchanged if there is no solution.
    ///
    /// # Errors
    /// The pose cannot be reached.
    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution;
    /// Finds all solutions for a pose. This may be slow; it is not for realtime.
    ///
    /// # Errors
    /// The pose cannot be reached.
    fn solutions(&self, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let mut joints = [0.0; 16];
        let solved = self.inverse(pose, &mut joints)?;
        ways.push(&joints);
        Ok(solved)
    }
    /// Returns the number of kinematics types that can be selected.
    fn types(&self) -> u32 {
        1
    }
    /// Realtime. Selects a kinematics type, from 0. Returns false if it does not exist.
    fn switch(&self, to: u32) -> bool {
        to == 0
    }
}

/// Returns the table for `k`.
pub(crate) fn table<K: Kinematics>(k: &K) -> abi::Kinematics {
    let kind = match k.kind() {
        KinematicsKind::Identity => abi::Kinematics::IDENTITY,
        KinematicsKind::ForwardOnly => abi::Kinematics::FORWARD_ONLY,
        KinematicsKind::InverseOnly => abi::Kinematics::INVERSE_ONLY,
        KinematicsKind::Both => abi::Kinematics::BOTH,
    };
    let mut joint_of = [0; 12];
    for (letter, place) in joint_of.iter_mut().enumerate().take(9) {
        *place = k.joint_of(letter).map_or(0, |j| u8::try_from(j + 1).unwrap_or(0));
    }
    abi::Kinematics {
        size: abi::size::<abi::Kinematics>(),
        joints: u32::try_from(k.joints()).unwrap_or(0),
        kind,
        joint_of,
        ctx: core::ptr::null(),
        forward: Some(forward::<K>),
        inverse: Some(inverse::<K>),
        types: k.types(),
        solutions: Some(solutions::<K>),
        switch: Some(switch::<K>),
        worker_ctx: core::ptr::null(),
    }
}

/// # Safety
/// `ctx` must point to a live `K`. The arrays must hold `n` and nine numbers.
unsafe extern "C" fn forward<K: Kinematics>(
    ctx: *const c_void,
    joints: *const f64,
    n: usize,
    pose: *mut f64,
) -> Status {
    // SAFETY: this is the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    // SAFETY: the caller guarantees an array of `n` numbers.
    let joints = unsafe { core::slice::from_raw_parts(joints, n) };
    // SAFETY: the caller guarantees an array of nine numbers.
    let pose = unsafe { &mut *pose.cast::<Pose>() };
    if n < k.joints() {
        return Status::EINVAL;
    }
    status(k.forward(joints, pose))
}

/// # Safety
/// `ctx` must point to a live `K`. The arrays must hold nine and `n` numbers.
unsafe extern "C" fn inverse<K: Kinematics>(
    ctx: *const c_void,
    pose: *const f64,
    joints: *mut f64,
    n: usize,
) -> Status {
    // SAFETY: this is the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    // SAFETY: the caller guarantees an array of nine numbers.
    let pose = unsafe { &*pose.cast::<Pose>() };
    // SAFETY: the caller guarantees an array of `n` numbers.
    let joints = unsafe { core::slice::from_raw_parts_mut(joints, n) };
    if n < k.joints() {
        return Status::EINVAL;
    }
    status(k.inverse(pose, joints))
}

/// # Safety
/// `ctx` must point to a live `K`. The arrays must hold nine and `n * room` numbers.
unsafe extern "C" fn solutions<K: Kinematics>(
    ctx: *const c_void,
    pose: *const f64,
    into: *mut f64,
    n: usize,
    room: usize,
) -> Status {
    // SAFETY: this is the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    // SAFETY: the caller guarantees an array of nine numbers.
    let pose = unsafe { &*pose.cast::<Pose>() };
    let Some(len) = n.checked_mul(room).filter(|_| n >= k.joints()) else {
        return Status::EINVAL;
    };
    // SAFETY: the caller guarantees an array of `n * room` numbers.
    let into = unsafe { core::slice::from_raw_parts_mut(into, len) };
    let mut ways = Ways::new(into, n);
    match k.solutions(pose, &mut ways) {
        Ok(_) => Status(i32::try_from(ways.count()).unwrap_or(i32::MAX)),
        Err(why) => why.status(),
    }
}

/// # Safety
/// `ctx` must point to a live `K`.
unsafe extern "C" fn switch<K: Kinematics>(ctx: *const c_void, to: u32) -> Status {
    // SAFETY: this is the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    if k.switch(to) { Status::OK } else { Status::EINVAL }
}

/// Kinematics that another plugin offers.
#[derive(Clone, Copy, Debug)]
pub struct KinematicsRef(pub(crate) Found<abi::Kinematics, [Use; 0]>);

impl KinematicsRef {
    /// Returns the same kinematics for the calls of one worker, which may run at the same time as
    /// those of realtime functions. Kinematics that are not reentrant have a second copy for it.
    #[must_use]
    pub const fn for_worker(mut self) -> Self {
        if !self.0.table.worker_ctx.is_null() {
            self.0.table.ctx = self.0.table.worker_ctx;
        }
        self
    }

    /// Returns the number of joints.
    #[must_use]
    pub const fn joints(&self) -> usize {
        self.0.table.joints as usize
    }

    /// Returns the directions in which the kinematics can convert.
    #[must_use]
    pub const fn kind(&self) -> KinematicsKind {
        match self.0.table.kind {
            abi::Kinematics::IDENTITY => KinematicsKind::Identity,
            abi::Kinematics::FORWARD_ONLY => KinematicsKind::ForwardOnly,
            abi::Kinematics::INVERSE_ONLY => KinematicsKind::InverseOnly,
            _ => KinematicsKind::Both,
        }
    }

    /// Returns the first joint of a letter (x y z a b c u v w), if there is one.
    #[must_use]
    pub fn joint_of(&self, letter: usize) -> Option<usize> {
        self.0.table.joint_of.get(letter).and_then(|j| usize::from(*j).checked_sub(1))
    }

    /// Realtime. Computes a pose from joint positions. Leaves `pose` unchanged if there is no
    /// solution.
    ///
    /// # Errors
    /// No pose has these joint positions, or none is found.
    pub fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        let forward = self.0.table.forward.ok_or(Unsolved::Unreachable)?;
        // SAFETY: this is the provider's function; both arrays live for the duration of the call.
        solution(unsafe {
            forward(self.0.table.ctx, joints.as_ptr(), joints.len(), pose.as_mut_ptr())
        })
    }

    /// Realtime. Computes joint positions from a pose. Leaves `joints` unchanged if there is no
    /// solution.
    ///
    /// # Errors
    /// The pose cannot be reached.
    pub fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        let inverse = self.0.table.inverse.ok_or(Unsolved::Unreachable)?;
        // SAFETY: this is the provider's function; both arrays live for the duration of the call.
        solution(unsafe {
            inverse(self.0.table.ctx, pose.as_ptr(), joints.as_mut_ptr(), joints.len())
        })
    }

    /// Finds all solutions for a pose and returns their number. Stores as many as fit in `into`,
    /// each with [`joints`](Self::joints) numbers. This may be slow; it is not for realtime.
    ///
    /// # Errors
    /// The pose cannot be reached.
    pub fn solutions(&self, pose: &Pose, into: &mut [f64]) -> Result<usize, Unsolved> {
        let solutions = self.0.table.solutions.ok_or(Unsolved::Unreachable)?;
        let n = self.joints();
        let room = into.len().checked_div(n).unwrap_or(0);
        // SAFETY: this is the provider's function; both arrays live for the duration of the call.
        let found =
            unsafe { solutions(self.0.table.ctx, pose.as_ptr(), into.as_mut_ptr(), n, room) };
        usize::try_from(found.0).map_err(|_| Unsolved::from_status(found))
    }

    /// Returns the number of kinematics types that can be selected, at least 1.
    #[must_use]
    pub const fn types(&self) -> u32 {
        if self.0.table.types == 0 { 1 } else { self.0.table.types }
    }

    /// Realtime. Selects a kinematics type, from 0. Returns false if it does not exist.
    pub fn switch(&self, to: u32) -> bool {
        // SAFETY: this is the provider's function with its own context.
        self.0.table.switch.is_some_and(|f| unsafe { f(self.0.table.ctx, to) }.is_ok())
    }
}

impl Touch for KinematicsRef {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

//! The service `kinematics`: how joints and poses follow each other.

use crate::{
    Solution, Touch, Unsolved, Uses, Ways,
    abi::{self, Record, ServiceSpec, Status, Str, Use},
    shim,
    solved::{solution, status},
};
use core::ffi::c_void;

pub(crate) const NAME: &str = "kinematics";
pub(crate) const VERSION: u32 = 1;

/// x y z a b c u v w, in the machine's units and degrees.
pub type Pose = [f64; 9];

/// What kinematics can do.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum KinematicsKind {
    /// Joints are axes.
    Identity,
    /// Only from joints to a pose.
    ForwardOnly,
    /// Only from a pose to joints.
    InverseOnly,
    /// Both ways.
    Both,
}

/// Kinematics that a component offers: reentrant, no allocation, no locks.
pub trait Kinematics: Touch + Send + Sync + 'static {
    /// How many joints it moves.
    fn joints(&self) -> usize;
    /// What it can do.
    fn kind(&self) -> KinematicsKind;
    /// The first joint that follows each letter (x y z a b c u v w).
    fn joint_of(&self, letter: usize) -> Option<usize>;
    /// From joint positions to a pose, which holds the last one as a first guess, and stays as
    /// it is when there is no answer.
    ///
    /// # Errors
    /// No pose has these joints, or none is found.
    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution;
    /// From a pose to joint positions, which hold the last ones as a first guess, and stay as
    /// they are when there is no answer.
    ///
    /// # Errors
    /// The pose cannot be reached.
    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution;
    /// Every way to reach a pose. It may take its time: it is not for realtime.
    ///
    /// # Errors
    /// The pose cannot be reached.
    fn solutions(&self, pose: &Pose, ways: &mut Ways<'_>) -> Solution {
        let mut joints = [0.0; 16];
        let solved = self.inverse(pose, &mut joints)?;
        ways.push(&joints);
        Ok(solved)
    }
    /// How many types of kinematics there are to switch between.
    fn types(&self) -> u32 {
        1
    }
    /// Switches to a type, from 0; false when there is none. Realtime.
    fn switch(&self, to: u32) -> bool {
        to == 0
    }
}

struct Offered<K> {
    k: K,
    table: abi::Kinematics,
}

pub(crate) fn offer<K: Kinematics>(k: K, uses: &[Use]) -> ServiceSpec {
    let kind = match k.kind() {
        KinematicsKind::Identity => 1,
        KinematicsKind::ForwardOnly => 2,
        KinematicsKind::InverseOnly => 3,
        KinematicsKind::Both => 4,
    };
    let mut joint_of = [0; 12];
    for (letter, place) in joint_of.iter_mut().enumerate().take(9) {
        *place = k.joint_of(letter).map_or(0, |j| u8::try_from(j + 1).unwrap_or(0));
    }
    let table = abi::Kinematics {
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
    };
    let state = shim::give(Offered { k, table }).cast::<Offered<K>>();
    // SAFETY: just made and not shared yet.
    let offered = unsafe { &mut *state };
    offered.table.ctx = (&raw const offered.k).cast();
    ServiceSpec {
        size: abi::size::<ServiceSpec>(),
        version: VERSION,
        name: Str::new(NAME),
        table: (&raw const offered.table).cast(),
        state: state.cast(),
        free: Some(shim::free::<Offered<K>>),
        uses: uses.as_ptr(),
        n_uses: uses.len(),
    }
}

/// # Safety
/// `ctx` is a live `K`; the arrays hold `n` and nine numbers.
unsafe extern "C" fn forward<K: Kinematics>(
    ctx: *const c_void,
    joints: *const f64,
    n: usize,
    pose: *mut f64,
) -> Status {
    // SAFETY: the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    // SAFETY: the caller's array.
    let joints = unsafe { core::slice::from_raw_parts(joints, n) };
    // SAFETY: the caller's array of nine.
    let pose = unsafe { &mut *pose.cast::<Pose>() };
    if n < k.joints() {
        return Status::EINVAL;
    }
    status(k.forward(joints, pose))
}

/// # Safety
/// `ctx` is a live `K`; the arrays hold nine and `n` numbers.
unsafe extern "C" fn inverse<K: Kinematics>(
    ctx: *const c_void,
    pose: *const f64,
    joints: *mut f64,
    n: usize,
) -> Status {
    // SAFETY: the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    // SAFETY: the caller's array of nine.
    let pose = unsafe { &*pose.cast::<Pose>() };
    // SAFETY: the caller's array.
    let joints = unsafe { core::slice::from_raw_parts_mut(joints, n) };
    if n < k.joints() {
        return Status::EINVAL;
    }
    status(k.inverse(pose, joints))
}

/// # Safety
/// `ctx` is a live `K`; the arrays hold nine and `n * room` numbers.
unsafe extern "C" fn solutions<K: Kinematics>(
    ctx: *const c_void,
    pose: *const f64,
    into: *mut f64,
    n: usize,
    room: usize,
) -> Status {
    // SAFETY: the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    // SAFETY: the caller's array of nine.
    let pose = unsafe { &*pose.cast::<Pose>() };
    let Some(len) = n.checked_mul(room).filter(|_| n >= k.joints()) else {
        return Status::EINVAL;
    };
    // SAFETY: the caller's array.
    let into = unsafe { core::slice::from_raw_parts_mut(into, len) };
    let mut ways = Ways::new(into, n);
    match k.solutions(pose, &mut ways) {
        Ok(_) => Status(i32::try_from(ways.count()).unwrap_or(i32::MAX)),
        Err(why) => why.status(),
    }
}

/// # Safety
/// `ctx` is a live `K`.
unsafe extern "C" fn switch<K: Kinematics>(ctx: *const c_void, to: u32) -> Status {
    // SAFETY: the table's own context.
    let k = unsafe { &*ctx.cast::<K>() };
    if k.switch(to) { Status::OK } else { Status::EINVAL }
}

/// Kinematics that another plugin offers.
#[derive(Clone, Copy, Debug)]
pub struct KinematicsRef(abi::Kinematics);

// SAFETY: the functions are reentrant and the provider stays loaded while its user is.
unsafe impl Send for KinematicsRef {}
// SAFETY: as for `Send`.
unsafe impl Sync for KinematicsRef {}

/// # Safety
/// `table` is null or the live table of a service of this name and version.
pub(crate) unsafe fn found(table: *const c_void) -> Option<KinematicsRef> {
    // SAFETY: the caller's promise.
    unsafe { abi::Kinematics::read(table.cast()) }.map(KinematicsRef)
}

impl KinematicsRef {
    /// How many joints it moves.
    #[must_use]
    pub const fn joints(&self) -> usize {
        self.0.joints as usize
    }

    /// What it can do.
    #[must_use]
    pub const fn kind(&self) -> KinematicsKind {
        match self.0.kind {
            1 => KinematicsKind::Identity,
            2 => KinematicsKind::ForwardOnly,
            3 => KinematicsKind::InverseOnly,
            _ => KinematicsKind::Both,
        }
    }

    /// The first joint that follows a letter (x y z a b c u v w), if one does.
    #[must_use]
    pub fn joint_of(&self, letter: usize) -> Option<usize> {
        self.0.joint_of.get(letter).and_then(|j| usize::from(*j).checked_sub(1))
    }

    /// From joint positions to a pose, which stays as it is without an answer. Realtime.
    ///
    /// # Errors
    /// No pose has these joints, or none is found.
    pub fn forward(&self, joints: &[f64], pose: &mut Pose) -> Solution {
        let forward = self.0.forward.ok_or(Unsolved::Unreachable)?;
        // SAFETY: the provider's function; both arrays live across the call.
        solution(unsafe { forward(self.0.ctx, joints.as_ptr(), joints.len(), pose.as_mut_ptr()) })
    }

    /// From a pose to joint positions, which stay as they are without an answer. Realtime.
    ///
    /// # Errors
    /// The pose cannot be reached.
    pub fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Solution {
        let inverse = self.0.inverse.ok_or(Unsolved::Unreachable)?;
        // SAFETY: the provider's function; both arrays live across the call.
        solution(unsafe { inverse(self.0.ctx, pose.as_ptr(), joints.as_mut_ptr(), joints.len()) })
    }

    /// How many ways there are to reach a pose; as many as have room are in `into`, each of
    /// [`joints`](Self::joints) numbers. It may take its time: it is not for realtime.
    ///
    /// # Errors
    /// The pose cannot be reached.
    pub fn solutions(&self, pose: &Pose, into: &mut [f64]) -> Result<usize, Unsolved> {
        let solutions = self.0.solutions.ok_or(Unsolved::Unreachable)?;
        let n = self.joints();
        let room = into.len().checked_div(n).unwrap_or(0);
        // SAFETY: the provider's function; both arrays live across the call.
        let found = unsafe { solutions(self.0.ctx, pose.as_ptr(), into.as_mut_ptr(), n, room) };
        usize::try_from(found.0).map_err(|_| Unsolved::from_status(found))
    }

    /// How many types of kinematics there are to switch between: 1 when none.
    #[must_use]
    pub const fn types(&self) -> u32 {
        if self.0.types == 0 { 1 } else { self.0.types }
    }

    /// Switches to a type, from 0; false when there is none. Realtime.
    pub fn switch(&self, to: u32) -> bool {
        // SAFETY: the provider's function.
        self.0.switch.is_some_and(|f| unsafe { f(self.0.ctx, to) }.is_ok())
    }
}

impl Touch for KinematicsRef {
    fn touch(&self, _: &mut Uses) {}
}

//! Realtime. Kinematics of a module in C as the service `kinematics`.
//!
//! Such a module keeps its state in static variables, and its functions expect one thread. The service therefore has two
//! copies of the module's file, each with variables of its own: one for the realtime functions, and one for the planner's
//! worker, which solves poses at the same time. Neither waits for the other.

pub(crate) mod offer;
#[cfg(test)]
mod tests;

use crate::{module::Module, running, second_copy::Input};
use core::{
    ffi::{c_int, c_ulong, c_void},
    sync::atomic::{
        AtomicBool, AtomicU32, AtomicU64,
        Ordering::{Acquire, Relaxed, Release},
    },
};
use hal_component::abi::{Kinematics, Status};
use std::sync::Arc;

/// Number of joint positions that a module may read and write.
const JOINTS: usize = 16;

type Joints = [f64; JOINTS];
/// Pose with the layout of `EmcPose`.
type Pose = [f64; 9];

/// Type of `kinematicsForward` and `kinematicsInverse`.
type SolveFunction = extern "C" fn(*const f64, *mut f64, *const c_ulong, *mut c_ulong) -> c_int;
/// Type of `kinematicsType` and `kinematicsSwitchable`.
type NumberFunction = extern "C" fn() -> c_int;
/// Type of `kinematicsSwitch`.
type SwitchFunction = extern "C" fn(c_int) -> c_int;

/// Functions of a module, with the types of `kinematics.h`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries {
    forward: SolveFunction,
    inverse: SolveFunction,
    pub(crate) kind: NumberFunction,
    switchable: Option<NumberFunction>,
    switch: Option<SwitchFunction>,
}

/// State that both copies follow.
#[derive(Debug)]
struct Common {
    /// Number of kinematics types.
    types: u32,
    /// Type in force.
    selected: AtomicU32,
    /// True once the module has reported a configuration, such as that of an elbow, with flags.
    has_flags: AtomicBool,
}

/// Copy of a module, which one thread at a time may enter.
#[derive(Debug)]
struct Solver {
    entries: Entries,
    /// Inputs that are refreshed before each call.
    inputs: Box<[Input]>,
    common: Arc<Common>,
    /// True while a thread is in the module.
    busy: AtomicBool,
    /// Type that this copy has selected.
    selected: AtomicU32,
    /// Flags of the last inverse, for the next forward.
    forward_flags: AtomicU64,
    /// Flags of the last forward, for the next inverse.
    inverse_flags: AtomicU64,
    module: Arc<Module>,
}

// SAFETY: `busy` lets one thread at a time into the module and to the memory of its inputs.
unsafe impl Send for Solver {}
// SAFETY: as for `Send`.
unsafe impl Sync for Solver {}

/// Offered service: the table and what its contexts point at.
#[derive(Debug)]
struct BothSolvers {
    table: Kinematics,
    /// Second copy of the module; declared first, because it reads the items of the first copy.
    planner_copy: Solver,
    /// First copy.
    motion_copy: Solver,
}

impl Solver {
    fn new(
        entries: Entries,
        inputs: Box<[Input]>,
        common: Arc<Common>,
        module: Arc<Module>,
    ) -> Self {
        Self {
            entries,
            inputs,
            common,
            busy: AtomicBool::new(false),
            selected: AtomicU32::new(0),
            forward_flags: AtomicU64::new(0),
            inverse_flags: AtomicU64::new(0),
            module,
        }
    }

    /// Runs code of the module, unless another thread does. Returns its result.
    fn run(&self, code: impl FnOnce() -> c_int) -> Option<c_int> {
        // Acquire pairs with the Release below: a call sees the variables that the last one left.
        if self.busy.compare_exchange(false, true, Acquire, Relaxed).is_err() {
            return None;
        }
        let result = running::within(Arc::as_ptr(&self.module), || {
            self.inputs.iter().for_each(Input::refresh);
            code()
        });
        // Release pairs with the Acquire above.
        self.busy.store(false, Release);
        Some(result)
    }

    /// Selects the type in force, if the other copy has changed it.
    fn follow(&self) -> c_int {
        let wanted = self.common.selected.load(Relaxed);
        if wanted == self.selected.load(Relaxed) { 0 } else { self.select(wanted) }
    }

    fn select(&self, to: u32) -> c_int {
        let code = self.entries.select(c_int::try_from(to).unwrap_or(c_int::MAX));
        if code == 0 {
            self.selected.store(to, Relaxed);
        }
        code
    }

    /// Calls a function of the module. Its own flags were reported by the last call of the other direction; those that it
    /// reports are for that one.
    fn solve(
        &self,
        code: SolveFunction,
        from: &[f64],
        to: &mut [f64],
        flags: [&AtomicU64; 2],
    ) -> c_int {
        let [own, reported] = flags;
        let (own, mut new) = (own.load(Relaxed), reported.load(Relaxed));
        let code = code(from.as_ptr(), to.as_mut_ptr(), &raw const own, &raw mut new);
        if code == 0 {
            reported.store(new, Relaxed);
        }
        code
    }

    /// Calls `kinematicsForward`.
    fn to_pose(&self, joints: &Joints, pose: &mut Pose) -> c_int {
        let flags = [&self.forward_flags, &self.inverse_flags];
        let code = self.solve(self.entries.forward, joints, pose, flags);
        if code == 0 && self.inverse_flags.load(Relaxed) != 0 {
            self.common.has_flags.store(true, Relaxed);
        }
        code
    }

    /// Calls `kinematicsInverse`. For a module with flags, those of the guess select the configuration.
    fn to_joints(&self, pose: &Pose, joints: &mut Joints) -> c_int {
        if self.common.has_flags.load(Relaxed) {
            // Without a pose for the guess, the last flags remain.
            self.to_pose(joints, &mut pose.clone());
        }
        let flags = [&self.inverse_flags, &self.forward_flags];
        self.solve(self.entries.inverse, pose, joints, flags)
    }

    fn forward(&self, joints: &[f64], pose: &mut Pose) -> Status {
        let Some(joints) = padded(joints).filter(|_| is_finite(pose)) else {
            return Status::EINVAL;
        };
        let mut found = *pose;
        let code = self.run(|| match self.follow() {
            0 => self.to_pose(&joints, &mut found),
            code => code,
        });
        let status = status_of(code, &found);
        if status.is_ok() {
            *pose = found;
        }
        status
    }

    fn inverse(&self, pose: &Pose, joints: &mut [f64]) -> Status {
        let Some(mut found) = padded(joints).filter(|_| is_finite(pose)) else {
            return Status::EINVAL;
        };
        let code = self.run(|| match self.follow() {
            0 => self.to_joints(pose, &mut found),
            code => code,
        });
        let status = status_of(code, &found);
        if status.is_ok() {
            for (to, from) in joints.iter_mut().zip(found) {
                *to = from;
            }
        }
        status
    }

    fn switch(&self, to: u32) -> Status {
        let common = &self.common;
        if to >= common.types {
            return Status::EINVAL;
        }
        if common.types > 1 {
            if self.run(|| self.select(to)) != Some(0) {
                return Status::EINVAL;
            }
            common.selected.store(to, Relaxed);
        }
        Status::OK
    }
}

/// Returns the status of a call: any result but zero, and any NaN, means that there is no solution.
fn status_of(code: Option<c_int>, found: &[f64]) -> Status {
    match code {
        None => Kinematics::NOT_FOUND,
        Some(0) if is_finite(found) => Status::OK,
        Some(_) => Kinematics::UNREACHABLE,
    }
}

fn is_finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// Returns joint positions with room for as many as a module may use.
fn padded(joints: &[f64]) -> Option<Joints> {
    let mut all = [0.0; JOINTS];
    for (to, from) in all.iter_mut().zip(joints) {
        *to = *from;
    }
    is_finite(&all).then_some(all)
}

/// # Safety
/// `ctx` must point to a live [`Solver`]. The arrays must hold `n` and nine numbers.
unsafe extern "C" fn forward(
    ctx: *const c_void,
    joints: *const f64,
    n: usize,
    pose: *mut f64,
) -> Status {
    // SAFETY: this is the table's own context.
    let solver = unsafe { &*ctx.cast::<Solver>() };
    // SAFETY: the caller guarantees an array of `n` numbers.
    let joints = unsafe { core::slice::from_raw_parts(joints, n) };
    // SAFETY: the caller guarantees an array of nine numbers.
    let pose = unsafe { &mut *pose.cast::<Pose>() };
    solver.forward(joints, pose)
}

/// # Safety
/// `ctx` must point to a live [`Solver`]. The arrays must hold nine and `n` numbers.
unsafe extern "C" fn inverse(
    ctx: *const c_void,
    pose: *const f64,
    joints: *mut f64,
    n: usize,
) -> Status {
    // SAFETY: this is the table's own context.
    let solver = unsafe { &*ctx.cast::<Solver>() };
    // SAFETY: the caller guarantees an array of nine numbers.
    let pose = unsafe { &*pose.cast::<Pose>() };
    // SAFETY: the caller guarantees an array of `n` numbers.
    let joints = unsafe { core::slice::from_raw_parts_mut(joints, n) };
    solver.inverse(pose, joints)
}

/// # Safety
/// `ctx` must point to a live [`Solver`].
unsafe extern "C" fn switch(ctx: *const c_void, to: u32) -> Status {
    // SAFETY: this is the table's own context.
    unsafe { &*ctx.cast::<Solver>() }.switch(to)
}

//! Calls of a copy of a module, which is a set of functions here.

use super::{Common, Entries, JOINTS, Pose, Solver};
use crate::module::Module;
use core::{
    cell::Cell,
    ffi::{c_int, c_ulong},
    mem::MaybeUninit,
    sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};
use hal_component::abi::{CallHost, ForeignFile, Host, Kinematics, Record, Status};
use std::{path::PathBuf, sync::Arc};

thread_local! {
    /// Argument of each call of `kinematicsSwitch` in this test.
    static SWITCHES: Cell<Vec<c_int>> = const { Cell::new(Vec::new()) };
    /// Result of the next calls of the other functions.
    static RESULT: Cell<(c_int, f64)> = const { Cell::new((0, 0.0)) };
}

extern "C" fn solve(_: *const f64, to: *mut f64, _: *const c_ulong, _: *mut c_ulong) -> c_int {
    let (code, value) = RESULT.get();
    // SAFETY: the solver's array.
    unsafe { to.write(value) };
    code
}

extern "C" fn one() -> c_int {
    1
}

/// Refuses type 2.
extern "C" fn switch(to: c_int) -> c_int {
    SWITCHES.set([SWITCHES.take(), vec![to]].concat());
    if to == 2 { -1 } else { 0 }
}

fn zeroed<R: Record>() -> R {
    // SAFETY: zero is a valid record.
    unsafe { MaybeUninit::zeroed().assume_init() }
}

/// Returns two copies of kinematics with `types` types.
fn copies(types: u32) -> [Solver; 2] {
    let calls = Box::leak(Box::new(zeroed::<CallHost>()));
    let host = Host { calls, ..zeroed() };
    let common =
        Arc::new(Common { types, selected: AtomicU32::new(0), has_flags: AtomicBool::new(false) });
    let entries = Entries {
        forward: solve,
        inverse: solve,
        kind: one,
        switchable: None,
        switch: Some(switch),
    };
    [(); 2].map(|()| {
        // SAFETY: opens this program itself.
        let handle = unsafe { libc::dlopen(core::ptr::null(), libc::RTLD_NOW) };
        let names = (PathBuf::new(), "kins", "");
        let module = Module::new(&host, zeroed::<ForeignFile>(), names, handle);
        Solver::new(entries, Box::default(), common.clone(), Arc::new(module))
    })
}

/// Returns the result of the forward kinematics and the pose after it.
fn forward(solver: &Solver) -> (Status, f64) {
    let mut pose: Pose = [7.0; 9];
    let status = solver.forward(&[1.0; JOINTS], &mut pose);
    (status, pose[0])
}

/// Returns the result of the inverse kinematics and the first joint after it.
fn inverse(solver: &Solver) -> (Status, f64) {
    let mut joints = [7.0; 3];
    let status = solver.inverse(&[1.0; 9], &mut joints);
    (status, joints[0])
}

#[test]
fn a_second_thread_gets_no_solution_and_leaves_the_output() {
    let [solver, other] = copies(1);
    RESULT.set((0, 5.0));
    assert_eq!([forward(&solver), inverse(&solver)], [(Status::OK, 5.0); 2]);
    solver.busy.store(true, Relaxed);
    assert_eq!([forward(&solver), inverse(&solver)], [(Kinematics::NOT_FOUND, 7.0); 2]);
    assert_eq!([forward(&other), inverse(&other)], [(Status::OK, 5.0); 2]);
    solver.busy.store(false, Relaxed);
    assert_eq!([forward(&solver), inverse(&solver)], [(Status::OK, 5.0); 2]);
}

#[test]
fn a_failure_and_a_number_that_is_none_leave_the_output() {
    let [solver, _] = copies(1);
    for result in [(-1, 5.0), (1, 5.0), (0, f64::NAN), (0, f64::INFINITY)] {
        RESULT.set(result);
        let none = (Kinematics::UNREACHABLE, 7.0);
        assert_eq!([forward(&solver), inverse(&solver)], [none; 2], "{result:?}");
    }
    RESULT.set((0, 5.0));
    let mut pose = [f64::NAN; 9];
    assert_eq!(solver.forward(&[1.0; 3], &mut pose), Status::EINVAL);
    assert_eq!(solver.inverse(&pose, &mut [1.0; 3]), Status::EINVAL);
}

#[test]
fn a_refused_type_changes_nothing() {
    let [solver, _] = copies(3);
    RESULT.set((0, 5.0));
    assert_eq!([1, 2, 3].map(|to| solver.switch(to)), [Status::OK, Status::EINVAL, Status::EINVAL]);
    assert_eq!(solver.common.selected.load(Relaxed), 1);
    assert_eq!(forward(&solver), (Status::OK, 5.0));
    // Type 3 does not exist, and the last call had nothing to switch.
    assert_eq!(SWITCHES.take(), [1, 2]);
    solver.busy.store(true, Relaxed);
    assert_eq!(solver.switch(0), Status::EINVAL);
    assert_eq!(SWITCHES.take(), []);
}

#[test]
fn a_copy_follows_the_type_that_the_other_has_selected() {
    let [motion, planner] = copies(3);
    RESULT.set((0, 5.0));
    assert_eq!(motion.switch(1), Status::OK);
    assert_eq!(SWITCHES.take(), [1]);
    assert_eq!([forward(&planner), inverse(&planner)], [(Status::OK, 5.0); 2]);
    assert_eq!(SWITCHES.take(), [1]);
    // A type that this copy refuses is tried with each call, which has no solution.
    motion.common.selected.store(2, Relaxed);
    let none = (Kinematics::UNREACHABLE, 7.0);
    assert_eq!([forward(&planner), inverse(&planner)], [none; 2]);
    assert_eq!(SWITCHES.take(), [2, 2]);
}

//! Layout of the records of joints.

use super::{
    offer::numbers,
    record::{JointRecord, PlannerRecord},
};
use core::{ffi::c_ulong, mem::offset_of};
use hal_component::abi::{HomingJoint, homing_flags, size};

unsafe extern "C" {
    /// Sizes and places in the records of `motion.h`, by the compiler of C; a zero ends them.
    static ferrule_joint_layout: [c_ulong; 37];
}

macro_rules! places {
    ($record:ty: $($field:ident)*) => {
        vec![size_of::<$record>(), $(offset_of!($record, $field)),*]
    };
}

#[test]
fn the_record_is_that_of_the_header() {
    // SAFETY: a constant of `shim.c`.
    let in_c = unsafe { &ferrule_joint_layout };
    let planner = places!(PlannerRecord: pos_cmd max_vel max_acc enable curr_pos curr_vel active);
    let joint = places!(JointRecord: max_pos_limit min_pos_limit max_jog_limit min_jog_limit
        vel_limit acc_limit min_ferror max_ferror backlash pos_cmd vel_cmd acc_cmd backlash_corr
        backlash_filt backlash_vel motor_pos_cmd motor_pos_fb pos_fb ferror ferror_limit
        motor_offset free_tp kb_jjog_active wheel_jjog_active on_pos_limit on_neg_limit flag);
    let in_rust: Vec<c_ulong> =
        [planner, joint, vec![0]].concat().iter().map(|n| *n as u64).collect();
    assert_eq!(in_rust, in_c);
}

#[test]
fn a_module_changes_positions_and_the_planner_alone() {
    let given = HomingJoint {
        size: size::<HomingJoint>(),
        flags: homing_flags::ACTIVE | homing_flags::AT_MIN | homing_flags::PLANNER_ON,
        max_limit: 1.0,
        min_limit: 2.0,
        max_jog: 3.0,
        min_jog: 4.0,
        max_velocity: 5.0,
        max_acceleration: 6.0,
        min_ferror: 7.0,
        max_ferror: 8.0,
        backlash: 9.0,
        pos_cmd: 10.0,
        vel_cmd: 11.0,
        acc_cmd: 12.0,
        backlash_corr: 13.0,
        backlash_filt: 14.0,
        backlash_vel: 15.0,
        motor_pos_cmd: 16.0,
        motor_pos_fb: 17.0,
        pos_fb: 18.0,
        ferror: 19.0,
        ferror_limit: 20.0,
        motor_offset: 21.0,
        target: 22.0,
        planner_velocity: 23.0,
        planner_acceleration: 24.0,
        planner_pos: 25.0,
        planner_vel: 26.0,
    };
    let record = JointRecord::of(&given);
    // Each number of the record in the order of those of the joint.
    let (r, tp) = (&record, &record.free_tp);
    let numbers = [
        [r.max_pos_limit, r.min_pos_limit, r.max_jog_limit, r.min_jog_limit, r.vel_limit],
        [r.acc_limit, r.min_ferror, r.max_ferror, r.backlash, r.pos_cmd],
        [r.vel_cmd, r.acc_cmd, r.backlash_corr, r.backlash_filt, r.backlash_vel],
        [r.motor_pos_cmd, r.motor_pos_fb, r.pos_fb, r.ferror, r.ferror_limit],
        [r.motor_offset, tp.pos_cmd, tp.max_vel, tp.max_acc, tp.curr_pos],
    ];
    assert!(numbers.concat().into_iter().eq((1..=25).map(f64::from)), "{numbers:?}");
    assert_eq!((tp.curr_vel, tp.enable, tp.active), (26.0, 1, 0));
    assert_eq!((r.flag, r.on_neg_limit, r.on_pos_limit), (0x22, 1, 0));
    assert_eq!((r.kb_jjog_active, r.wheel_jjog_active), (0, 0));
    let mut same = given;
    record.store(&mut same);
    assert_eq!(same, given);
    let mut changed = JointRecord { vel_limit: 7.0, pos_cmd: 2.0, flag: 0, ..record };
    changed.free_tp.enable = 0;
    changed.store(&mut same);
    let flags = given.flags & !homing_flags::PLANNER_ON;
    assert_eq!(same, HomingJoint { pos_cmd: 2.0, flags, ..given });
}

#[test]
fn a_module_gets_no_more_joints_than_its_arrays_hold() {
    assert_eq!(numbers([16, 3]), Ok([16, 3]));
    let refused = |joints| numbers(joints).unwrap_err();
    assert_eq!(refused([17, 0]), "it homes 16 joints at most, not 17");
    assert_eq!(refused([1, u32::MAX]), "it homes 16 joints at most, not 2147483647");
}

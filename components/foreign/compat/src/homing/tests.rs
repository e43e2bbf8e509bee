//! Layout of the records of joints.

use super::record::{JointRecord, PlannerRecord};
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
    let ones = [1.0; 26];
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, x, y, z] = ones;
    let given = HomingJoint {
        size: size::<HomingJoint>(),
        flags: homing_flags::ACTIVE | homing_flags::AT_MIN | homing_flags::PLANNER_ON,
        max_limit: a,
        min_limit: b,
        max_jog: c,
        min_jog: d,
        max_velocity: e,
        max_acceleration: f,
        min_ferror: g,
        max_ferror: h,
        backlash: i,
        pos_cmd: j,
        vel_cmd: k,
        acc_cmd: l,
        backlash_corr: m,
        backlash_filt: n,
        backlash_vel: o,
        motor_pos_cmd: p,
        motor_pos_fb: q,
        pos_fb: r,
        ferror: s,
        ferror_limit: t,
        motor_offset: u,
        target: v,
        planner_velocity: w,
        planner_acceleration: x,
        planner_pos: y,
        planner_vel: z,
    };
    let record = JointRecord::of(&given);
    let bits = (record.flag, record.on_neg_limit, record.on_pos_limit, record.free_tp.enable);
    assert_eq!(bits, (0x22, 1, 0, 1));
    let mut same = given;
    record.store(&mut same);
    assert_eq!(same, given);
    let mut changed = JointRecord { vel_limit: 7.0, pos_cmd: 2.0, flag: 0, ..record };
    changed.free_tp.enable = 0;
    changed.store(&mut same);
    let flags = given.flags & !homing_flags::PLANNER_ON;
    assert_eq!(same, HomingJoint { pos_cmd: 2.0, flags, ..given });
}

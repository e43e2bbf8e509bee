//! Realtime. Record of a joint as `motion.h` has it.

use core::ffi::{c_int, c_ushort};
use hal_component::abi::{HomingJoint, homing_flags as flags};

/// Planner of a joint, with the layout of `simple_tp_t`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlannerRecord {
    pub(crate) pos_cmd: f64,
    pub(crate) max_vel: f64,
    pub(crate) max_acc: f64,
    pub(crate) enable: c_int,
    pub(crate) curr_pos: f64,
    pub(crate) curr_vel: f64,
    pub(crate) active: c_int,
}

/// Joint, with the layout of `emcmot_joint_t`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointRecord {
    pub(crate) max_pos_limit: f64,
    pub(crate) min_pos_limit: f64,
    pub(crate) max_jog_limit: f64,
    pub(crate) min_jog_limit: f64,
    pub(crate) vel_limit: f64,
    pub(crate) acc_limit: f64,
    pub(crate) min_ferror: f64,
    pub(crate) max_ferror: f64,
    pub(crate) backlash: f64,
    pub(crate) pos_cmd: f64,
    pub(crate) vel_cmd: f64,
    pub(crate) acc_cmd: f64,
    pub(crate) backlash_corr: f64,
    pub(crate) backlash_filt: f64,
    pub(crate) backlash_vel: f64,
    pub(crate) motor_pos_cmd: f64,
    pub(crate) motor_pos_fb: f64,
    pub(crate) pos_fb: f64,
    pub(crate) ferror: f64,
    pub(crate) ferror_limit: f64,
    pub(crate) motor_offset: f64,
    pub(crate) free_tp: PlannerRecord,
    pub(crate) kb_jjog_active: c_int,
    pub(crate) wheel_jjog_active: c_int,
    pub(crate) on_pos_limit: c_int,
    pub(crate) on_neg_limit: c_int,
    pub(crate) flag: c_ushort,
}

impl JointRecord {
    pub(crate) fn of(from: &HomingJoint) -> Self {
        let has = |bit: u32| c_int::from(from.flags & bit != 0);
        Self {
            max_pos_limit: from.max_limit,
            min_pos_limit: from.min_limit,
            max_jog_limit: from.max_jog,
            min_jog_limit: from.min_jog,
            vel_limit: from.max_velocity,
            acc_limit: from.max_acceleration,
            min_ferror: from.min_ferror,
            max_ferror: from.max_ferror,
            backlash: from.backlash,
            pos_cmd: from.pos_cmd,
            vel_cmd: from.vel_cmd,
            acc_cmd: from.acc_cmd,
            backlash_corr: from.backlash_corr,
            backlash_filt: from.backlash_filt,
            backlash_vel: from.backlash_vel,
            motor_pos_cmd: from.motor_pos_cmd,
            motor_pos_fb: from.motor_pos_fb,
            pos_fb: from.pos_fb,
            ferror: from.ferror,
            ferror_limit: from.ferror_limit,
            motor_offset: from.motor_offset,
            free_tp: PlannerRecord {
                pos_cmd: from.target,
                max_vel: from.planner_velocity,
                max_acc: from.planner_acceleration,
                enable: has(flags::PLANNER_ON),
                curr_pos: from.planner_pos,
                curr_vel: from.planner_vel,
                active: has(flags::PLANNER_ACTIVE),
            },
            kb_jjog_active: has(flags::KB_JOG),
            wheel_jjog_active: has(flags::WHEEL_JOG),
            on_pos_limit: has(flags::AT_MAX),
            on_neg_limit: has(flags::AT_MIN),
            flag: c_ushort::from(from.flags.to_le_bytes()[0]),
        }
    }

    /// Stores the fields that a module may change.
    pub(crate) const fn store(&self, to: &mut HomingJoint) {
        to.pos_cmd = self.pos_cmd;
        to.pos_fb = self.pos_fb;
        to.motor_offset = self.motor_offset;
        to.target = self.free_tp.pos_cmd;
        to.planner_velocity = self.free_tp.max_vel;
        to.planner_pos = self.free_tp.curr_pos;
        to.flags = if self.free_tp.enable != 0 {
            to.flags | flags::PLANNER_ON
        } else {
            to.flags & !flags::PLANNER_ON
        };
    }
}

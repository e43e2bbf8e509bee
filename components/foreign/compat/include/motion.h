/* Sizes of the motion module, and its joints as a homing module sees them. */
#ifndef MOTION_H
#define MOTION_H
#include "emcmotcfg.h"
#include "emcpos.h"
#include "kinematics.h"
#include "posemath.h"
#include "rtapi_bool.h"
#include "rtapi_limits.h"
#include "simple_tp.h"

typedef enum {
    EMCMOT_MOTION_DISABLED = 0,
    EMCMOT_MOTION_FREE,
    EMCMOT_MOTION_TELEOP,
    EMCMOT_MOTION_COORD
} motion_state_t;

/* Bits of a joint's flag. */
typedef unsigned short EMCMOT_JOINT_FLAG;
#define EMCMOT_JOINT_ENABLE_BIT 0x0001
#define EMCMOT_JOINT_ACTIVE_BIT 0x0002
#define EMCMOT_JOINT_INPOS_BIT 0x0004
#define EMCMOT_JOINT_ERROR_BIT 0x0008
#define EMCMOT_JOINT_MAX_HARD_LIMIT_BIT 0x0010
#define EMCMOT_JOINT_MIN_HARD_LIMIT_BIT 0x0020
#define EMCMOT_JOINT_FERROR_BIT 0x0040
#define EMCMOT_JOINT_FAULT_BIT 0x0080

#define GET_JOINT_ACTIVE_FLAG(joint) (((joint)->flag & EMCMOT_JOINT_ACTIVE_BIT) != 0)
#define GET_JOINT_INPOS_FLAG(joint) (((joint)->flag & EMCMOT_JOINT_INPOS_BIT) != 0)

/* A joint, in machine units and seconds. The motion controller writes all fields before it calls the module. Of the
 * module's changes, it takes those of free_tp (pos_cmd, max_vel, enable, and curr_pos with pos_cmd) and of pos_cmd,
 * pos_fb and motor_offset, which must change together. */
typedef struct {
    /* Limits of position, of jogs, of velocity, acceleration and following error. */
    double max_pos_limit;
    double min_pos_limit;
    double max_jog_limit;
    double min_jog_limit;
    double vel_limit;
    double acc_limit;
    double min_ferror;
    double max_ferror;
    double backlash;
    /* Commanded position, velocity and acceleration. */
    double pos_cmd;
    double vel_cmd;
    double acc_cmd;
    /* Correction of backlash: its target, its value, its velocity. */
    double backlash_corr;
    double backlash_filt;
    double backlash_vel;
    /* Of the motor: the last command, and the measured position. */
    double motor_pos_cmd;
    double motor_pos_fb;
    /* Measured position: motor_pos_fb - (backlash_filt + motor_offset). */
    double pos_fb;
    double ferror;
    double ferror_limit;
    /* Position of the motor at which the joint is at zero. */
    double motor_offset;
    /* The joint's own planner, which moves it in free mode. */
    simple_tp_t free_tp;
    /* Not 0 while a command or a wheel jogs the joint. */
    int kb_jjog_active;
    int wheel_jjog_active;
    /* Not 0 at a limit switch. */
    int on_pos_limit;
    int on_neg_limit;
    EMCMOT_JOINT_FLAG flag;
} emcmot_joint_t;
#endif

component at_once "Homing of a user that takes each joint as homed where it stands, and gives that place its home offset.";
pin out bit is_module = 1 "TRUE: the module is loaded.";
option homemod yes;
license "GPL";
author "none";
;;
#include "motion.h"
#include "homing.h"

static char *home_parms = "none";
RTAPI_MP_STRING(home_parms, "A text that the module shows as it is loaded.")

static emcmot_joint_t *joints;
static int n_joints;
static struct {
    hal_bit_t *homing;
    hal_bit_t *homed;
} *pins;
static struct {
    double offset;
    bool wanted;
    bool homed;
} all[EMCMOT_MAX_JOINTS];

void homeMotFunctions(void (*set_unlock)(int, int), int (*get_unlock)(int))
{
    (void)set_unlock;
    (void)get_unlock;
}

int homing_init(int id, double servo_period, int n, int n_extra, emcmot_joint_t *records)
{
    int fault = 0;
    (void)servo_period;
    (void)n_extra;
    rtapi_print_msg(RTAPI_MSG_DBG, "at_once: %s\n", home_parms);
    joints = records;
    n_joints = n;
    pins = hal_malloc(n * sizeof *pins);
    if (!pins)
        return -1;
    for (int j = 0; j < n; j++) {
        fault |= hal_pin_bit_newf(HAL_OUT, &pins[j].homing, id, "joint.%d.homing", j);
        fault |= hal_pin_bit_newf(HAL_OUT, &pins[j].homed, id, "joint.%d.homed", j);
        all[j].homed = all[j].wanted = false;
    }
    return fault;
}

void set_joint_homing_params(int j, double offset, double home, double final_vel, double search_vel,
                             double latch_vel, int flags, int sequence, bool is_volatile)
{
    (void)home, (void)final_vel, (void)search_vel, (void)latch_vel;
    (void)flags, (void)sequence, (void)is_volatile;
    all[j].offset = offset;
}

void update_joint_homing_params(int j, double offset, double home, int sequence)
{
    (void)home, (void)sequence;
    all[j].offset = offset;
}

void read_homing_in_pins(int n)
{
    (void)n;
}

bool get_allhomed(void)
{
    for (int j = 0; j < n_joints; j++)
        if (GET_JOINT_ACTIVE_FLAG(&joints[j]) && !all[j].homed)
            return false;
    return true;
}

bool do_homing(void)
{
    bool before = get_allhomed();
    for (int j = 0; j < n_joints; j++) {
        emcmot_joint_t *joint = &joints[j];
        if (!all[j].wanted || joint->free_tp.active)
            continue;
        double shift = all[j].offset - joint->pos_fb;
        joint->pos_cmd += shift;
        joint->pos_fb += shift;
        joint->free_tp.curr_pos += shift;
        joint->motor_offset -= shift;
        all[j].wanted = false;
        all[j].homed = true;
    }
    return !before && get_allhomed();
}

void write_homing_out_pins(int n)
{
    for (int j = 0; j < n; j++) {
        *pins[j].homing = all[j].wanted;
        *pins[j].homed = all[j].homed;
    }
}

void do_home_joint(int joint)
{
    for (int j = 0; j < n_joints; j++)
        if ((joint < 0 || j == joint) && GET_JOINT_ACTIVE_FLAG(&joints[j])) {
            joints[j].free_tp.enable = 0;
            all[j].wanted = true;
            all[j].homed = false;
        }
}

void do_cancel_homing(int j)
{
    all[j].wanted = false;
}

void set_unhomed(int joint, motion_state_t state)
{
    (void)state;
    for (int j = 0; j < n_joints; j++)
        if (joint == -1 || j == joint)
            all[j].homed = false;
}

bool get_homing_is_active(void)
{
    for (int j = 0; j < n_joints; j++)
        if (all[j].wanted)
            return true;
    return false;
}

int get_home_sequence(int j)
{
    (void)j;
    return 0;
}

bool get_homing(int j)
{
    return all[j].wanted;
}

bool get_homed(int j)
{
    return all[j].homed;
}

bool get_index_enable(int j)
{
    (void)j;
    return false;
}

bool get_home_needs_unlock_first(int j)
{
    (void)j;
    return false;
}

bool get_home_is_idle(int j)
{
    return !all[j].wanted;
}

bool get_home_is_synchronized(int j)
{
    (void)j;
    return false;
}

bool get_homing_at_index_search_wait(int j)
{
    (void)j;
    return false;
}

#include "exports.h"

/* Homing of a user with faults, by the pin bad.fault: joint 0 goes 10 units in positive direction and is homed there at 5.
 * A second joint is never homed. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_math.h"
#include "hal.h"
#include "motion.h"
#include "homing.h"

MODULE_LICENSE("GPL");

enum fault {
    NONE,
    NAN_OFFSET,
    INFINITE_TARGET,
    OFFSET_ALONE,
    COMMAND_ALONE,
    PLANNER_LEFT,
    NEGATIVE_VELOCITY,
    FAR_AND_FAST,
    NEVER_BEGINS,
    NEVER_ENDS,
    GIVES_UP,
    MOVES_UNASKED,
    RENAMES_UNASKED,
    KEEPS_ON,
    CLAIMS,
    CRASHES,
    STOPS_LATE,
    NAN_FEEDBACK,
    MOVES_ANOTHER,
    RENAMES_ANOTHER,
};

static struct pins {
    hal_s32_t *fault;
    hal_bit_t *homed;
    hal_bit_t *homing;
} *pins;
static int crash;
RTAPI_MP_INT(crash, "1: crash as the pins are made; 2: never return from there.");

static int component;
static emcmot_joint_t *joints;
static bool is_wanted, is_homing, is_homed, is_in_turn;
static int n_joints;

int rtapi_app_main(void)
{
    int made;
    component = hal_init("bad");
    if (component < 0)
        return component;
    pins = hal_malloc(sizeof *pins);
    made = pins ? hal_pin_s32_newf(HAL_IN, &pins->fault, component, "bad.fault") : -1;
    if (made < 0) {
        hal_exit(component);
        return made;
    }
    is_wanted = is_homing = is_homed = is_in_turn = false;
    return hal_ready(component);
}

void rtapi_app_exit(void)
{
    hal_exit(component);
}

void homeMotFunctions(void (*set)(int, int), int (*get)(int))
{
    (void)set;
    (void)get;
}

int homing_init(int id, double servo_period, int n, int n_extra, emcmot_joint_t *records)
{
    int made;
    (void)servo_period;
    (void)n_extra;
    if (n > 2)
        return -1;
    n_joints = n;
    if (crash == 1)
        *(volatile int *)8 = 1;
    while (crash == 2)
        ;
    joints = records;
    made = hal_pin_bit_newf(HAL_OUT, &pins->homed, id, "joint.0.homed");
    return made ? made : hal_pin_bit_newf(HAL_OUT, &pins->homing, id, "joint.0.homing");
}

static void go(int j, double target, double velocity)
{
    simple_tp_t *tp = &joints[j].free_tp;
    tp->pos_cmd = target;
    tp->max_vel = velocity;
    tp->enable = 1;
}

static void rename_to(int j, double place)
{
    emcmot_joint_t *joint = &joints[j];
    double shift = place - joint->pos_fb;
    joint->pos_cmd += shift;
    joint->pos_fb += shift;
    joint->motor_offset -= shift;
    if (*pins->fault != PLANNER_LEFT)
        joint->free_tp.curr_pos += shift;
}

static void begin(void)
{
    double target = joints[0].pos_cmd + 10.0;
    is_wanted = false;
    is_homing = true;
    is_homed = false;
    switch (*pins->fault) {
    case INFINITE_TARGET:
        target = INFINITY;
        break;
    case FAR_AND_FAST:
        return go(0, 1e9, 1e9);
    case NEGATIVE_VELOCITY:
        return go(0, target, -20.0);
    case CRASHES:
        *(volatile int *)8 = 1;
        break;
    case MOVES_ANOTHER:
        if (n_joints > 1)
            go(1, 30.0, 20.0);
        break;
    case RENAMES_ANOTHER:
        if (n_joints > 1)
            rename_to(1, 7.0);
        break;
    default:
        break;
    }
    go(0, target, 20.0);
}

static void end(void)
{
    emcmot_joint_t *joint = &joints[0];
    switch (*pins->fault) {
    case NAN_OFFSET:
        joint->motor_offset = NAN;
        break;
    case NAN_FEEDBACK:
        joint->pos_fb = NAN;
        break;
    case OFFSET_ALONE:
        joint->motor_offset += 3.0;
        break;
    case COMMAND_ALONE:
        joint->pos_cmd += 3.0;
        joint->free_tp.curr_pos += 3.0;
        break;
    case NEVER_ENDS:
    case KEEPS_ON:
        go(0, joint->pos_cmd + (joint->pos_cmd > 5.0 ? -10.0 : 10.0), 20.0);
        return;
    case GIVES_UP:
        is_homing = false;
        return;
    default:
        rename_to(0, 5.0);
    }
    is_homing = false;
    is_homed = true;
}

/* Modules for older versions of LinuxCNC have it, before each call of do_homing. */
void do_homing_sequence(void)
{
    is_in_turn = true;
}
EXPORT_SYMBOL(do_homing_sequence);

bool do_homing(void)
{
    emcmot_joint_t *joint = &joints[0];
    if (!is_in_turn)
        return false;
    is_in_turn = false;
    if (*pins->fault == MOVES_UNASKED && is_homed && !is_homing)
        go(0, 0.0, 20.0);
    if (*pins->fault == RENAMES_UNASKED && is_homed && !is_homing)
        rename_to(0, 7.0);
    if (*pins->fault == NEVER_BEGINS)
        return false;
    if (is_wanted)
        begin();
    else if (is_homing && !joint->free_tp.active)
        end();
    else if (is_homing && *pins->fault == STOPS_LATE && joint->pos_cmd > 4.0)
        is_homing = false, is_homed = true;
    return false;
}

void do_home_joint(int joint)
{
    (void)joint;
    is_wanted = true;
}

void do_cancel_homing(int joint)
{
    (void)joint;
    if (*pins->fault == KEEPS_ON)
        return;
    is_wanted = is_homing = false;
    is_homed = *pins->fault == CLAIMS;
}

void set_unhomed(int joint, motion_state_t state)
{
    (void)joint;
    (void)state;
    if (*pins->fault != CLAIMS && *pins->fault != RENAMES_UNASKED)
        is_homed = false;
}

void read_homing_in_pins(int n)
{
    (void)n;
}

void write_homing_out_pins(int n)
{
    (void)n;
    *pins->homed = is_homed;
    *pins->homing = is_homing;
}

void set_joint_homing_params(int j, double offset, double home, double final_vel, double search_vel,
                             double latch_vel, int flags, int sequence, bool is_volatile)
{
    (void)j, (void)offset, (void)home, (void)final_vel, (void)search_vel, (void)latch_vel;
    (void)flags, (void)sequence, (void)is_volatile;
}

void update_joint_homing_params(int j, double offset, double home, int sequence)
{
    (void)j, (void)offset, (void)home, (void)sequence;
}

bool get_allhomed(void)
{
    return is_homed;
}

bool get_homing_is_active(void)
{
    return is_homing;
}

int get_home_sequence(int j)
{
    (void)j;
    return 0;
}

bool get_homing(int j)
{
    return j == 0 && is_homing;
}

bool get_homed(int j)
{
    return j == 0 && is_homed;
}

bool get_home_is_idle(int j)
{
    return j != 0 || (!is_homing && !is_wanted);
}

#define NEVER(name)     \
    bool name(int j)    \
    {                   \
        (void)j;        \
        return false;   \
    }

NEVER(get_index_enable)
NEVER(get_home_needs_unlock_first)
NEVER(get_home_is_synchronized)
NEVER(get_homing_at_index_search_wait)

#include "exports.h"

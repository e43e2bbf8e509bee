/* Homing of a user: each joint searches its switch with a state machine of the module's own, comes off it slowly, takes the
 * edge or the next index as its home offset, and goes home. Joints are homed in the order of their sequence; those of one
 * number below 0 go home together. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_math.h"
#include "hal.h"
#include "motion.h"
#include "homing.h"

MODULE_LICENSE("GPL");

enum step { IDLE, START, SEARCH, SLOW, EDGE, INDEX, REST, READY, FINAL, CANCELLED };

static int component;
static emcmot_joint_t *joints;
static int n_joints;
static void (*set_unlock)(int, int);
static int (*get_unlock)(int);

static struct pins {
    hal_bit_t *home_sw_in;
    hal_bit_t *homing;
    hal_bit_t *homed;
    hal_bit_t *index_enable;
    hal_s32_t *home_state;
    hal_s32_t *flags;
    hal_s32_t *updates;
} *pins;

static struct own {
    enum step step;
    bool homed;
    /* Homed later, in its turn. */
    bool later;
    bool is_volatile;
    bool at_switch;
    bool index_enable;
    double offset;
    double home;
    double final_vel;
    double search_vel;
    double latch_vel;
    int flags;
    int sequence;
    /* Number of calls of update_joint_homing_params. */
    int updates;
} all[EMCMOT_MAX_JOINTS];

int rtapi_app_main(void)
{
    component = hal_init("search");
    if (component < 0)
        return component;
    return hal_ready(component);
}

void rtapi_app_exit(void)
{
    hal_exit(component);
}

void homeMotFunctions(void (*set)(int, int), int (*get)(int))
{
    set_unlock = set;
    get_unlock = get;
}

int homing_init(int id, double servo_period, int n, int n_extra, emcmot_joint_t *records)
{
    int fault = servo_period > 0.0 ? 0 : -1;
    (void)n_extra;
    joints = records;
    n_joints = n;
    pins = hal_malloc(n * sizeof *pins);
    if (!pins)
        return -1;
    for (int j = 0; j < n; j++) {
        struct pins *p = &pins[j];
        fault |= hal_pin_bit_newf(HAL_IN, &p->home_sw_in, id, "joint.%d.home-sw-in", j);
        fault |= hal_pin_bit_newf(HAL_OUT, &p->homing, id, "joint.%d.homing", j);
        fault |= hal_pin_bit_newf(HAL_OUT, &p->homed, id, "joint.%d.homed", j);
        fault |= hal_pin_bit_newf(HAL_IO, &p->index_enable, id, "joint.%d.index-enable", j);
        fault |= hal_pin_s32_newf(HAL_OUT, &p->home_state, id, "joint.%d.home-state", j);
        fault |= hal_pin_s32_newf(HAL_OUT, &p->flags, id, "search.flags-%d", j);
        fault |= hal_pin_s32_newf(HAL_OUT, &p->updates, id, "search.updates-%d", j);
        all[j] = (struct own){ .sequence = 100 };
    }
    return fault;
}

void set_joint_homing_params(int j, double offset, double home, double final_vel, double search_vel,
                             double latch_vel, int flags, int sequence, bool is_volatile)
{
    struct own *h = &all[j];
    h->offset = offset;
    h->home = home;
    h->final_vel = final_vel;
    h->search_vel = search_vel;
    h->latch_vel = latch_vel;
    h->flags = flags;
    h->sequence = sequence;
    h->is_volatile = is_volatile;
}

void update_joint_homing_params(int j, double offset, double home, int sequence)
{
    all[j].offset = offset;
    all[j].home = home;
    all[j].sequence = sequence;
    all[j].updates++;
}

void read_homing_in_pins(int n)
{
    for (int j = 0; j < n; j++) {
        all[j].at_switch = *pins[j].home_sw_in;
        all[j].index_enable = *pins[j].index_enable;
    }
}

void write_homing_out_pins(int n)
{
    for (int j = 0; j < n; j++) {
        *pins[j].homing = all[j].step != IDLE;
        *pins[j].homed = all[j].homed;
        *pins[j].home_state = all[j].step;
        *pins[j].flags = all[j].flags;
        *pins[j].updates = all[j].updates;
        *pins[j].index_enable = all[j].index_enable;
    }
}

static void go(int j, double target, double velocity)
{
    simple_tp_t *tp = &joints[j].free_tp;
    tp->pos_cmd = target;
    tp->max_vel = fabs(velocity);
    tp->enable = 1;
}

/* Moves at a velocity, as far as the joint may have to. */
static void search(int j, double velocity)
{
    double way = 2.0 * (joints[j].max_pos_limit - joints[j].min_pos_limit);
    go(j, joints[j].pos_cmd + (velocity > 0.0 ? way : -way), velocity);
}

static void stop(int j)
{
    joints[j].free_tp.enable = 0;
}

/* Gives the place of the joint another number, without motion. */
static void rename_to(int j, double place)
{
    emcmot_joint_t *joint = &joints[j];
    double shift = place - joint->pos_fb;
    joint->pos_cmd += shift;
    joint->pos_fb += shift;
    joint->free_tp.curr_pos += shift;
    joint->motor_offset -= shift;
}

/* Takes the zero of an encoder that its index has just reset. */
static void take_index(int j)
{
    emcmot_joint_t *joint = &joints[j];
    joint->motor_offset = -all[j].offset;
    joint->pos_fb = joint->motor_pos_fb - (joint->backlash_filt + joint->motor_offset);
    joint->pos_cmd = joint->pos_fb;
    joint->free_tp.curr_pos = joint->pos_fb;
}

static void give_up(int j, const char *why)
{
    rtapi_print_msg(RTAPI_MSG_ERR, "search: joint %d: %s\n", j, why);
    for (int k = 0; k < n_joints; k++) {
        all[k].later = false;
        if (all[k].step != IDLE)
            all[k].step = CANCELLED;
    }
}

static bool is_at_limit(int j)
{
    return (joints[j].on_pos_limit || joints[j].on_neg_limit) &&
           !(all[j].flags & HOME_IGNORE_LIMITS);
}

/* Whether all joints that go home together with this one may. */
static bool may_go_home(int j)
{
    if (all[j].sequence >= 0)
        return true;
    for (int k = 0; k < n_joints; k++) {
        bool together = all[k].sequence == all[j].sequence;
        if (together && all[k].step != IDLE && all[k].step != READY && all[k].step != FINAL)
            return false;
    }
    return true;
}

static void step(int j)
{
    struct own *h = &all[j];
    simple_tp_t *tp = &joints[j].free_tp;
    switch (h->step) {
    case IDLE:
        break;
    case START:
        if (tp->active)
            break;
        if (h->flags & HOME_UNLOCK_FIRST) {
            set_unlock(j, 1);
            if (!get_unlock(j))
                break;
        }
        if (h->search_vel == 0.0) {
            rename_to(j, h->offset);
            h->step = READY;
        } else {
            search(j, h->search_vel);
            h->step = SEARCH;
        }
        break;
    case SEARCH:
        if (is_at_limit(j)) {
            give_up(j, "on a limit switch");
        } else if (h->at_switch) {
            stop(j);
            h->step = SLOW;
        } else if (!tp->active) {
            give_up(j, "no switch");
        }
        break;
    case SLOW:
        if (!tp->active) {
            search(j, -h->search_vel / fabs(h->search_vel) * fabs(h->latch_vel));
            h->step = EDGE;
        }
        break;
    case EDGE:
        if (h->at_switch)
            break;
        if (h->flags & HOME_USE_INDEX) {
            h->index_enable = true;
            h->step = INDEX;
        } else {
            rename_to(j, h->offset);
            stop(j);
            h->step = REST;
        }
        break;
    case INDEX:
        if (!h->index_enable) {
            take_index(j);
            stop(j);
            h->step = REST;
        }
        break;
    case REST:
        if (!tp->active)
            h->step = READY;
        break;
    case READY:
        if (may_go_home(j)) {
            go(j, h->home, h->final_vel > 0.0 ? h->final_vel : joints[j].vel_limit);
            h->step = FINAL;
        }
        break;
    case FINAL:
        if (!tp->active) {
            stop(j);
            if (h->flags & HOME_UNLOCK_FIRST)
                set_unlock(j, 0);
            h->homed = true;
            h->step = IDLE;
        }
        break;
    case CANCELLED:
        stop(j);
        h->index_enable = false;
        h->homed = false;
        if (h->flags & HOME_UNLOCK_FIRST)
            set_unlock(j, 0);
        h->step = IDLE;
        break;
    }
}

static void begin(int j)
{
    stop(j);
    all[j].step = START;
    all[j].homed = false;
    all[j].later = false;
}

static int size_of_sequence(int j)
{
    return all[j].sequence < 0 ? -all[j].sequence : all[j].sequence;
}

/* Begins with the next joints in the sequence. */
static void begin_next(void)
{
    int first = 1000;
    for (int j = 0; j < n_joints; j++) {
        if (all[j].step != IDLE)
            return;
        if (all[j].later && size_of_sequence(j) < first)
            first = size_of_sequence(j);
    }
    for (int j = 0; j < n_joints; j++)
        if (all[j].later && size_of_sequence(j) == first)
            begin(j);
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
    begin_next();
    for (int j = 0; j < n_joints; j++)
        if (GET_JOINT_ACTIVE_FLAG(&joints[j]))
            step(j);
    return !before && get_allhomed();
}

void do_home_joint(int joint)
{
    for (int j = 0; j < n_joints; j++) {
        bool together = joint >= 0 && all[j].sequence < 0 && all[j].sequence == all[joint].sequence;
        if ((joint < 0 || j == joint || together) && GET_JOINT_ACTIVE_FLAG(&joints[j]))
            all[j].later = true;
    }
}

void do_cancel_homing(int j)
{
    all[j].later = false;
    if (all[j].step != IDLE)
        all[j].step = CANCELLED;
}

void set_unhomed(int joint, motion_state_t state)
{
    if (state != EMCMOT_MOTION_FREE && state != EMCMOT_MOTION_DISABLED)
        return;
    for (int j = 0; j < n_joints; j++)
        if (joint == -1 || j == joint || (joint == -2 && all[j].is_volatile))
            all[j].homed = false;
}

bool get_homing_is_active(void)
{
    for (int j = 0; j < n_joints; j++)
        if (all[j].step != IDLE || all[j].later)
            return true;
    return false;
}

int get_home_sequence(int j)
{
    return all[j].sequence;
}

bool get_homing(int j)
{
    return all[j].step != IDLE;
}

bool get_homed(int j)
{
    return all[j].homed;
}

bool get_index_enable(int j)
{
    return all[j].index_enable;
}

bool get_home_needs_unlock_first(int j)
{
    return all[j].flags & HOME_UNLOCK_FIRST;
}

bool get_home_is_idle(int j)
{
    return all[j].step == IDLE && !all[j].later;
}

bool get_home_is_synchronized(int j)
{
    return all[j].sequence < 0;
}

bool get_homing_at_index_search_wait(int j)
{
    return all[j].step == INDEX;
}

#include "exports.h"

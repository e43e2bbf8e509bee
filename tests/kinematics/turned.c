/* Kinematics of a user: the motors of X and Y stand turned by an angle that a pin sets.
 *
 * As is usual for such modules, its variables are static, and it does not bear two calls at once: a call that finds
 * another one in the module is counted. The pin fault makes it fail on purpose: 1 no solution, 2 NaN, 3 a crash with the
 * next pose, 4 a crash with a pose beyond x 5, which the planner meets first; 5 and 6 are the same in the C library. */
#include <string.h>
#include "module.h"
#include "rtapi_math.h"

static char *coordinates = "XYZ";
RTAPI_MP_STRING(coordinates, "letters of the axes");

static struct pins {
    hal_float_t *angle, *reach;
    hal_s32_t *fault;
    hal_u32_t *overlaps, *solved;
} *pins;
static int id;
static volatile int inside;
static double sine, cosine;

static int begin(void)
{
    if (inside++)
        (*pins->overlaps)++;
    sine = sin(*pins->angle * (M_PI / 180));
    cosine = cos(*pins->angle * (M_PI / 180));
    return 0;
}

static int end(int code, int crashes, int crashes_in_library)
{
    static volatile int *nowhere;
    static const char *volatile no_text;
    if (crashes)
        *nowhere = 1;
    if (crashes_in_library)
        code = (int)strlen(no_text);
    inside--;
    return code;
}

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)forward;
    (void)inverse;
    begin();
    pose->tran.x = joints[0] * cosine + joints[1] * sine;
    pose->tran.y = joints[1] * cosine - joints[0] * sine;
    pose->tran.z = joints[2];
    return end(0, *pins->fault == 3, *pins->fault == 5);
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    (void)inverse;
    begin();
    (*pins->solved)++;
    /* What is written before a refusal must not reach a joint. */
    joints[0] = 1e6;
    if (*pins->fault == 1 || fabs(pose->tran.x) > *pins->reach)
        return end(-1, 0, 0);
    joints[0] = pose->tran.x * cosine - pose->tran.y * sine;
    joints[1] = pose->tran.x * sine + pose->tran.y * cosine;
    joints[2] = *pins->fault == 2 ? NAN : pose->tran.z;
    const int is_beyond = pose->tran.x > 5;
    return end(0, *pins->fault == 4 && is_beyond, *pins->fault == 6 && is_beyond);
}

BOTH_WAYS

int rtapi_app_main(void)
{
    if (coordinates[0] != 'X' && coordinates[0] != 'x') {
        rtapi_print_msg(RTAPI_MSG_ERR, "turned: coordinates=%s must begin with X\n", coordinates);
        return -EINVAL;
    }
    id = hal_init("turned");
    if (id < 0)
        return id;
    pins = hal_malloc(sizeof *pins);
    if (!pins || hal_pin_float_new("turned.angle", HAL_IN, &pins->angle, id)
        || hal_pin_float_new("turned.reach", HAL_IN, &pins->reach, id)
        || hal_pin_s32_new("turned.fault", HAL_IN, &pins->fault, id)
        || hal_pin_u32_new("turned.overlaps", HAL_OUT, &pins->overlaps, id)
        || hal_pin_u32_new("turned.solved", HAL_OUT, &pins->solved, id)) {
        hal_exit(id);
        return -ENOMEM;
    }
    *pins->angle = 30;
    *pins->reach = 1000;
    return hal_ready(id);
}

void rtapi_app_exit(void) { hal_exit(id); }

/* Kinematics of two types, which begin in type 1, where X is reversed, and report the kind of type 0. The parameter fault
 * makes them fail on purpose as they are loaded: 1 the second copy makes another pin, 2 it makes one and reports success,
 * 3 a crash in kinematicsSwitch, 4 type 0 is not selected twice, 5 shared memory, 6 a stream of both copies, 7 calls
 * that are refused in both copies, and without which they can do. */
#include <stdlib.h>
#include "module.h"

static int fault;
RTAPI_MP_INT(fault, "failure on purpose, 1 to 7");
static struct pins {
    hal_float_t *other;
} *pins;
static hal_stream_t stream;
static int id, type = 1;

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)forward;
    (void)inverse;
    pose->tran.x = type ? -joints[0] : joints[0];
    pose->tran.y = joints[1];
    pose->tran.z = joints[2];
    return 0;
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    (void)inverse;
    joints[0] = type ? -pose->tran.x : pose->tran.x;
    joints[1] = pose->tran.y;
    joints[2] = pose->tran.z;
    return 0;
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_IDENTITY; }

int kinematicsSwitchable(void) { return 1; }

int kinematicsSwitch(int to)
{
    static volatile int *nowhere;
    static int count;
    if (fault == 3)
        *nowhere = 1;
    if (to > 1 || (fault == 4 && count++ > 0))
        return -1;
    type = to;
    return 0;
}

EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsSwitchable);
EXPORT_SYMBOL(kinematicsSwitch);

/* Both copies are in one process, and see the same environment. */
static int is_second_copy(void)
{
    if (getenv("UNUSUAL_IS_LOADED"))
        return unsetenv("UNUSUAL_IS_LOADED") == 0;
    setenv("UNUSUAL_IS_LOADED", "1", 1);
    return 0;
}

static void nothing(void *arg, long period)
{
    (void)arg;
    (void)period;
}

int rtapi_app_main(void)
{
    const int second = is_second_copy();
    int code = 0;
    id = hal_init("unusual");
    if (id < 0)
        return id;
    pins = hal_malloc(sizeof *pins);
    if (!pins)
        return -ENOMEM;
    if ((fault == 1 || fault == 2) && second)
        code = hal_pin_float_new("unusual.other", HAL_IN, &pins->other, id);
    if (fault == 5)
        code = rtapi_shmem_new(77, id, 64);
    if (fault == 6 && second)
        code = hal_stream_attach(&stream, id, 77, "f");
    else if (fault == 6)
        code = hal_stream_create(&stream, id, 77, 16, "f");
    for (int i = 0; i < 2 && fault == 7; i++) {
        hal_pin_float_new("unusual.other", HAL_IN, &pins->other, id);
        hal_export_funct("unusual.nothing", nothing, NULL, 0, 0, id);
        hal_init("unusual");
    }
    if (code < 0 && fault != 2)
        return code;
    return hal_ready(id);
}

void rtapi_app_exit(void) { hal_exit(id); }

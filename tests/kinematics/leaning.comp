component leaning "Kinematics of a user as a .comp file: the motor of Y leans by a share of X";
description """
The pins of the kinematics are made when motion first asks for their type, as in LinuxCNC's examples.
""";
pin out u32 turns "Number of calls of the function.";
function tally;
license "GPL";
;;
#include <rtapi_math.h>
#include <kinematics.h>

static struct pins {
    hal_float_t *share;
} *pins;

static void make_pins(void)
{
    int id = hal_init("leaning-pins");
    if (id < 0)
        return;
    pins = hal_malloc(sizeof *pins);
    if (pins && hal_pin_float_newf(HAL_IN, &pins->share, id, "leaning.share"))
        pins = NULL;
    if (pins)
        *pins->share = 0.25;
    hal_ready(id);
}

FUNCTION(tally) { turns = turns + 1; }

EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
KINS_NOT_SWITCHABLE

KINEMATICS_TYPE kinematicsType(void)
{
    static int is_made;
    if (!is_made)
        make_pins();
    is_made = 1;
    return KINEMATICS_BOTH;
}

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)forward;
    (void)inverse;
    if (!pins)
        return -1;
    pose->tran.x = joints[0];
    pose->tran.y = joints[1] - *pins->share * joints[0];
    pose->tran.z = joints[2];
    return 0;
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    (void)inverse;
    if (!pins)
        return -1;
    joints[0] = pose->tran.x;
    joints[1] = pose->tran.y + *pins->share * pose->tran.x;
    joints[2] = pose->tran.z;
    return 0;
}

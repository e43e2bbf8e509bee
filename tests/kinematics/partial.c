/* Kinematics that motion refuses: their type is a parameter. */
#include "module.h"

static int type = KINEMATICS_INVERSE_ONLY;
RTAPI_MP_INT(type, "what kinematicsType returns");
static int id;

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)joints;
    (void)pose;
    (void)forward;
    (void)inverse;
    return -1;
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    (void)inverse;
    joints[0] = pose->tran.x;
    return 0;
}

KINEMATICS_TYPE kinematicsType(void)
{
    static int *volatile nowhere;
    return type == 99 ? (KINEMATICS_TYPE)*nowhere : (KINEMATICS_TYPE)type;
}

EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsType);

int rtapi_app_main(void)
{
    rtapi_print_msg(RTAPI_MSG_ERR, "partial: type %d\n", type);
    id = hal_init("partial");
    return id < 0 ? id : hal_ready(id);
}

void rtapi_app_exit(void) { hal_exit(id); }

/* Kinematics without an inverse. */
#include "hal.h"
#include "kinematics.h"
#include "rtapi.h"
#include "rtapi_app.h"

MODULE_LICENSE("GPL");

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)joints;
    (void)pose;
    (void)forward;
    (void)inverse;
    return 0;
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_FORWARD_ONLY; }

EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsType);

int rtapi_app_main(void)
{
    int id = hal_init("half");
    return id < 0 ? id : hal_ready(id);
}

void rtapi_app_exit(void) {}

/* Kinematics without an inverse. */
#include "module.h"

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

COMPONENT("half")

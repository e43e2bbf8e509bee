/* Kinematics of a user with flags: an arm of two links of 100, whose forward kinematics report the side of the elbow,
 * and whose inverse kinematics take the side from there. */
#include "module.h"
#include "rtapi_math.h"

#define LINK 100.0
#define RIGHT 1

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)forward;
    const double a = joints[0] * (M_PI / 180), b = a + joints[1] * (M_PI / 180);
    *inverse = joints[1] < 0 ? RIGHT : 0;
    pose->tran.x = LINK * (cos(a) + cos(b));
    pose->tran.y = LINK * (sin(a) + sin(b));
    pose->tran.z = joints[2];
    return 0;
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    const double x = pose->tran.x, y = pose->tran.y;
    const double half = sqrt(x * x + y * y) / (2 * LINK);
    if (half > 1)
        return -1;
    const double bend = *inverse & RIGHT ? -acos(half) : acos(half);
    joints[0] = (atan2(y, x) - bend) * (180 / M_PI);
    joints[1] = 2 * bend * (180 / M_PI);
    joints[2] = pose->tran.z;
    return 0;
}

BOTH_WAYS
COMPONENT("elbow")

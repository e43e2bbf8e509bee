/* Kinematics of a user that need the last solution: joint 0 is a radius and joint 1 an angle of any number of turns,
 * next to the one before. Joint 2 is C, which the forward kinematics know up to whole turns: the last pose has them. */
#include "module.h"
#include "rtapi_math.h"

static double near(double angle, double last) { return angle + 360 * floor((last - angle) / 360 + 0.5); }

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)forward;
    (void)inverse;
    pose->tran.x = joints[0] * cos(joints[1] * (M_PI / 180));
    pose->tran.y = joints[0] * sin(joints[1] * (M_PI / 180));
    pose->c = near(fmod(joints[2], 360), pose->c);
    return 0;
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    (void)inverse;
    const double x = pose->tran.x, y = pose->tran.y;
    joints[0] = sqrt(x * x + y * y);
    if (joints[0] < 1e-6)
        return -1;
    joints[1] = near(atan2(y, x) * (180 / M_PI), joints[1]);
    joints[2] = pose->c;
    return 0;
}

BOTH_WAYS
COMPONENT("polar")

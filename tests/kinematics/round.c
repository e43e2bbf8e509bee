/* Kinematics of a user with the mathematics of rotatekins: X and Y stand on a rotary axis C. */
#include "module.h"
#include "rtapi_math.h"

static void turn(double *x, double *y, double degrees)
{
    const double s = sin(degrees * (M_PI / 180)), c = cos(degrees * (M_PI / 180));
    const double at = *x;
    *x = at * c - *y * s;
    *y = at * s + *y * c;
}

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    (void)forward;
    (void)inverse;
    *pose = (EmcPose){{joints[0], joints[1], joints[2]}, joints[3], joints[4], joints[5],
                      joints[6], joints[7], joints[8]};
    turn(&pose->tran.x, &pose->tran.y, -joints[5]);
    return 0;
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    (void)forward;
    (void)inverse;
    const double all[9] = {pose->tran.x, pose->tran.y, pose->tran.z, pose->a, pose->b, pose->c,
                           pose->u, pose->v, pose->w};
    for (int i = 0; i < 9; i++)
        joints[i] = all[i];
    turn(&joints[0], &joints[1], pose->c);
    return 0;
}

BOTH_WAYS
COMPONENT("round")

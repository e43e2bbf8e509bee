/* A pose: x y z, the angles a b c, and u v w. */
#ifndef EMCPOS_H
#define EMCPOS_H
#ifndef FERRULE_CARTESIAN
#define FERRULE_CARTESIAN
typedef struct {
    double x, y, z;
} PmCartesian;
#endif
typedef struct EmcPose {
    PmCartesian tran;
    double a, b, c;
    double u, v, w;
} EmcPose;
#define ZERO_EMC_POSE(pos)                                                              \
    do {                                                                                \
        (pos).tran.x = (pos).tran.y = (pos).tran.z = 0.0;                               \
        (pos).a = (pos).b = (pos).c = 0.0;                                              \
        (pos).u = (pos).v = (pos).w = 0.0;                                              \
    } while (0)
/* Also TO_RAD and TO_DEG. */
#include "posemath.h"
#endif

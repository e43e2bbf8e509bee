/* Numbers, vectors, rotations and poses under the names of gomath.h. The types are those of posemath.h. */
#ifndef GOTYPES_H
#define GOTYPES_H
#include <float.h>
#include <stddef.h>
#include "posemath.h"

typedef double go_real;
typedef int go_integer;
typedef int go_flag;
#define GO_REAL_MIN DBL_MIN
#define GO_REAL_MAX DBL_MAX
#define GO_REAL_EPSILON DBL_EPSILON

typedef int go_result;
enum {
    GO_RESULT_OK = 0,
    GO_RESULT_IGNORED,
    GO_RESULT_BAD_ARGS,
    GO_RESULT_RANGE_ERROR,
    GO_RESULT_DOMAIN_ERROR,
    GO_RESULT_ERROR,
    GO_RESULT_IMPL_ERROR,
    GO_RESULT_NORM_ERROR,
    GO_RESULT_DIV_ERROR,
    GO_RESULT_SINGULAR,
    GO_RESULT_NO_SPACE,
    GO_RESULT_EMPTY,
    GO_RESULT_BUG
};

typedef PmCartesian go_cart;
typedef PmCartesian go_vec;
typedef PmQuaternion go_quat;
typedef PmRotationMatrix go_mat;
typedef PmRpy go_rpy;
typedef PmPose go_pose;
typedef PmHomogeneous go_hom;
typedef PmRotationVector go_rvec;
typedef PmSpherical go_sph;
typedef PmCylindrical go_cyl;
typedef PmEulerZyx go_zyx;
typedef PmEulerZyz go_zyz;
#endif

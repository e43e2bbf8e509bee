/* Vectors, rotations and poses, as kinematics modules use them. Angles are in radians. The columns of a rotation matrix
 * are the turned unit vectors; roll, pitch and yaw turn about the fixed x, y and z, in this order.
 *
 * Each function returns zero, or -1 for a vector or quaternion without length. Results may be an argument. */
#ifndef POSEMATH_H
#define POSEMATH_H
#include "emcpos.h"
#include "rtapi_math.h"

#define PM_PI 3.14159265358979323846
#define PM_PI_2 1.57079632679489661923
#define PM_PI_4 0.78539816339744830962
#define PM_2_PI 6.28318530717958647692
#define TO_DEG (180.0 / PM_PI)
#define TO_RAD (PM_PI / 180.0)

typedef struct {
    double theta, phi, r;
} PmSpherical;
typedef struct {
    double theta, r, z;
} PmCylindrical;
typedef struct {
    double s, x, y, z;
} PmRotationVector;
typedef struct {
    PmCartesian x, y, z;
} PmRotationMatrix;
typedef struct {
    double s, x, y, z;
} PmQuaternion;
typedef struct {
    double z, y, x;
} PmEulerZyx;
typedef struct {
    double z, y, zp;
} PmEulerZyz;
typedef struct {
    double r, p, y;
} PmRpy;
typedef struct {
    PmCartesian tran;
    PmQuaternion rot;
} PmPose;
typedef struct {
    PmCartesian tran;
    PmRotationMatrix rot;
} PmHomogeneous;

static inline double pmSq(double x) { return x * x; }
static inline double pmSqrt(double x) { return x > 0.0 ? sqrt(x) : 0.0; }

static inline int pmCartCartDot(const PmCartesian *a, const PmCartesian *b, double *d)
{
    *d = a->x * b->x + a->y * b->y + a->z * b->z;
    return 0;
}
static inline int pmCartCartCross(const PmCartesian *a, const PmCartesian *b, PmCartesian *out)
{
    const PmCartesian c = {a->y * b->z - a->z * b->y, a->z * b->x - a->x * b->z,
                           a->x * b->y - a->y * b->x};
    *out = c;
    return 0;
}
static inline int pmCartMag(const PmCartesian *v, double *d)
{
    *d = sqrt(pmSq(v->x) + pmSq(v->y) + pmSq(v->z));
    return 0;
}
static inline int pmCartMagSq(const PmCartesian *v, double *d) { return pmCartCartDot(v, v, d); }
static inline int pmCartCartAdd(const PmCartesian *a, const PmCartesian *b, PmCartesian *out)
{
    const PmCartesian c = {a->x + b->x, a->y + b->y, a->z + b->z};
    *out = c;
    return 0;
}
static inline int pmCartCartSub(const PmCartesian *a, const PmCartesian *b, PmCartesian *out)
{
    const PmCartesian c = {a->x - b->x, a->y - b->y, a->z - b->z};
    *out = c;
    return 0;
}
static inline int pmCartCartDisp(const PmCartesian *a, const PmCartesian *b, double *d)
{
    PmCartesian c;
    pmCartCartSub(b, a, &c);
    return pmCartMag(&c, d);
}
static inline int pmCartScalMult(const PmCartesian *v, double d, PmCartesian *out)
{
    const PmCartesian c = {v->x * d, v->y * d, v->z * d};
    *out = c;
    return 0;
}
static inline int pmCartScalDiv(const PmCartesian *v, double d, PmCartesian *out)
{
    return d == 0.0 ? -1 : pmCartScalMult(v, 1.0 / d, out);
}
static inline int pmCartNeg(const PmCartesian *v, PmCartesian *out)
{
    return pmCartScalMult(v, -1.0, out);
}
static inline int pmCartUnit(const PmCartesian *v, PmCartesian *out)
{
    double d;
    pmCartMag(v, &d);
    return pmCartScalDiv(v, d, out);
}
static inline int pmMatCartMult(const PmRotationMatrix *m, const PmCartesian *v, PmCartesian *out)
{
    const PmCartesian c = {m->x.x * v->x + m->y.x * v->y + m->z.x * v->z,
                           m->x.y * v->x + m->y.y * v->y + m->z.y * v->z,
                           m->x.z * v->x + m->y.z * v->y + m->z.z * v->z};
    *out = c;
    return 0;
}
static inline int pmMatMatMult(const PmRotationMatrix *a, const PmRotationMatrix *b,
                               PmRotationMatrix *out)
{
    PmRotationMatrix c;
    pmMatCartMult(a, &b->x, &c.x);
    pmMatCartMult(a, &b->y, &c.y);
    pmMatCartMult(a, &b->z, &c.z);
    *out = c;
    return 0;
}
static inline int pmMatInv(const PmRotationMatrix *m, PmRotationMatrix *out)
{
    const PmRotationMatrix c = {{m->x.x, m->y.x, m->z.x},
                                {m->x.y, m->y.y, m->z.y},
                                {m->x.z, m->y.z, m->z.z}};
    *out = c;
    return 0;
}
static inline int pmRpyMatConvert(const PmRpy *angles, PmRotationMatrix *out)
{
    const double sr = sin(angles->r), cr = cos(angles->r);
    const double sp = sin(angles->p), cp = cos(angles->p);
    const double sy = sin(angles->y), cy = cos(angles->y);
    const PmRotationMatrix c = {{cp * cy, cp * sy, -sp},
                                {sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp},
                                {cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp}};
    *out = c;
    return 0;
}
static inline int pmMatRpyConvert(const PmRotationMatrix *m, PmRpy *out)
{
    const double across = sqrt(pmSq(m->x.x) + pmSq(m->x.y));
    out->p = atan2(-m->x.z, across);
    if (across < 1e-6) {
        /* The tool points along z: roll and yaw turn about one axis, and yaw is chosen zero. */
        out->r = m->x.z < 0.0 ? atan2(m->y.x, m->y.y) : -atan2(m->y.x, m->y.y);
        out->y = 0.0;
    } else {
        out->r = atan2(m->y.z, m->z.z);
        out->y = atan2(m->x.y, m->x.x);
    }
    return 0;
}
static inline int pmQuatMatConvert(const PmQuaternion *q, PmRotationMatrix *out)
{
    const double n = pmSq(q->s) + pmSq(q->x) + pmSq(q->y) + pmSq(q->z);
    if (n == 0.0)
        return -1;
    const double k = 2.0 / n;
    out->x.x = 1.0 - k * (pmSq(q->y) + pmSq(q->z));
    out->x.y = k * (q->x * q->y + q->z * q->s);
    out->x.z = k * (q->z * q->x - q->y * q->s);
    out->y.x = k * (q->x * q->y - q->z * q->s);
    out->y.y = 1.0 - k * (pmSq(q->z) + pmSq(q->x));
    out->y.z = k * (q->y * q->z + q->x * q->s);
    out->z.x = k * (q->z * q->x + q->y * q->s);
    out->z.y = k * (q->y * q->z - q->x * q->s);
    out->z.z = 1.0 - k * (pmSq(q->x) + pmSq(q->y));
    return 0;
}
static inline int pmMatQuatConvert(const PmRotationMatrix *m, PmQuaternion *out)
{
    /* Four times the square of each part; the largest is the one to divide by. */
    const double s = 1.0 + m->x.x + m->y.y + m->z.z, x = 1.0 + m->x.x - m->y.y - m->z.z;
    const double y = 1.0 - m->x.x + m->y.y - m->z.z, z = 1.0 - m->x.x - m->y.y + m->z.z;
    const double sx = m->y.z - m->z.y, sy = m->z.x - m->x.z, sz = m->x.y - m->y.x;
    const double xy = m->x.y + m->y.x, yz = m->y.z + m->z.y, zx = m->z.x + m->x.z;
    PmQuaternion q;
    if (s >= x && s >= y && s >= z)
        q = (PmQuaternion){s, sx, sy, sz};
    else if (x >= y && x >= z)
        q = (PmQuaternion){sx, x, xy, zx};
    else if (y >= z)
        q = (PmQuaternion){sy, xy, y, yz};
    else
        q = (PmQuaternion){sz, zx, yz, z};
    const double sign = q.s < 0.0 ? -1.0 : 1.0;
    const double n = sign * sqrt(pmSq(q.s) + pmSq(q.x) + pmSq(q.y) + pmSq(q.z));
    *out = (PmQuaternion){q.s / n, q.x / n, q.y / n, q.z / n};
    return 0;
}
static inline int pmQuatNorm(const PmQuaternion *q, PmQuaternion *out)
{
    const double n = sqrt(pmSq(q->s) + pmSq(q->x) + pmSq(q->y) + pmSq(q->z));
    if (n == 0.0)
        return -1;
    *out = (PmQuaternion){q->s / n, q->x / n, q->y / n, q->z / n};
    return 0;
}
static inline int pmQuatInv(const PmQuaternion *q, PmQuaternion *out)
{
    *out = (PmQuaternion){q->s, -q->x, -q->y, -q->z};
    return 0;
}
static inline int pmQuatQuatMult(const PmQuaternion *a, const PmQuaternion *b, PmQuaternion *out)
{
    *out = (PmQuaternion){a->s * b->s - a->x * b->x - a->y * b->y - a->z * b->z,
                          a->s * b->x + a->x * b->s + a->y * b->z - a->z * b->y,
                          a->s * b->y - a->x * b->z + a->y * b->s + a->z * b->x,
                          a->s * b->z + a->x * b->y - a->y * b->x + a->z * b->s};
    return 0;
}
static inline int pmQuatCartMult(const PmQuaternion *q, const PmCartesian *v, PmCartesian *out)
{
    PmRotationMatrix m;
    return pmQuatMatConvert(q, &m) ? -1 : pmMatCartMult(&m, v, out);
}
#endif

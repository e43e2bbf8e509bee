/* Kinematics of a user with two types, made by switchkins.h: in type 1 the motors of X and Y are crossed, and X is
 * offset by the pin away. */
#include "switchkins.h"
#include "rtapi_math.h"

MODULE_LICENSE("GPL");

static struct pins {
    hal_float_t *away;
} *pins;

static int make(const int component, const char *axes, kparms *parms)
{
    (void)axes;
    pins = hal_malloc(sizeof *pins);
    if (!pins)
        return -ENOMEM;
    return hal_pin_float_newf(HAL_IN, &pins->away, component, "%s.away", parms->halprefix);
}

#define FORWARD(name, a, b)                                                                       \
    static int name(const double *j, EmcPose *p, const KINEMATICS_FORWARD_FLAGS *f,               \
                    KINEMATICS_INVERSE_FLAGS *i)                                                  \
    {                                                                                             \
        (void)f;                                                                                  \
        (void)i;                                                                                  \
        p->tran.x = (a);                                                                          \
        p->tran.y = (b);                                                                          \
        p->tran.z = j[2];                                                                         \
        return 0;                                                                                 \
    }
#define INVERSE(name, a, b)                                                                       \
    static int name(const EmcPose *p, double *j, const KINEMATICS_INVERSE_FLAGS *i,               \
                    KINEMATICS_FORWARD_FLAGS *f)                                                  \
    {                                                                                             \
        (void)f;                                                                                  \
        (void)i;                                                                                  \
        j[0] = (a);                                                                               \
        j[1] = (b);                                                                               \
        j[2] = p->tran.z;                                                                         \
        return 0;                                                                                 \
    }
FORWARD(straight, j[0], j[1])
INVERSE(straight_back, p->tran.x, p->tran.y)
FORWARD(across, j[1] + *pins->away, j[0])
INVERSE(across_back, p->tran.y, p->tran.x - *pins->away)

int switchkinsSetup(kparms *parms, KS *s0, KS *s1, KS *s2, KF *f0, KF *f1, KF *f2, KI *i0, KI *i1,
                    KI *i2)
{
    (void)s1;
    (void)s2;
    (void)f2;
    (void)i2;
    parms->kinsname = parms->halprefix = "crossed";
    parms->required_coordinates = "xyz";
    *s0 = make;
    *f0 = straight;
    *i0 = straight_back;
    *f1 = across;
    *i1 = across_back;
    return 0;
}

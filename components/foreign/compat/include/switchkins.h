/* Kinematics of several types in one module, with a switch between them.
 *
 * The module defines switchkinsSetup, and the three functions of each of its types; this header makes the rest of it:
 * the entry points of a module, the parameters coordinates and sparm, the pins kinstype.is-0 and so on, and what motion
 * calls. Where a module has several C files, all but one define SWITCHKINS_TYPES_ONLY before they include it. */
#ifndef SWITCHKINS_H
#define SWITCHKINS_H
#include <ctype.h>
#include <string.h>
#include "hal.h"
#include "kinematics.h"
#include "rtapi.h"
#include "rtapi_app.h"

#define SWITCHKINS_MAX_TYPES 3

/* Makes the pins of a type, before motion calls its other functions: zero, or a negative error number. */
typedef int (*KS)(const int component, const char *coordinates, kparms *parms);
typedef int (*KF)(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                  KINEMATICS_INVERSE_FLAGS *inverse);
typedef int (*KI)(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                  KINEMATICS_FORWARD_FLAGS *forward);

RTAPI_BEGIN_DECLS
/* Names the types. kset2, kfwd2 and kinv2 may stay as they are, if there are two types only. */
extern int switchkinsSetup(kparms *parms, KS *kset0, KS *kset1, KS *kset2, KF *kfwd0, KF *kfwd1,
                           KF *kfwd2, KI *kinv0, KI *kinv1, KI *kinv2);
RTAPI_END_DECLS

/* One joint for each letter of coordinates, by its order there. */
static inline int switchkins_axes(const char *coordinates, int max_joints, int axis_of_joint[])
{
    static const char letters[] = "XYZABCUVW";
    int joints = 0;
    for (const char *c = coordinates; *c; c++) {
        const char upper = *c >= 'a' && *c <= 'z' ? (char)(*c - 'a' + 'A') : *c;
        const char *found = strchr(letters, upper);
        if (upper == ' ' || upper == '\t')
            continue;
        if (!found || joints >= max_joints) {
            rtapi_print_msg(RTAPI_MSG_ERR, "coordinates=%s: '%c' %s\n", coordinates, *c,
                            found ? "is one joint too many" : "names no axis");
            return -EINVAL;
        }
        axis_of_joint[joints++] = (int)(found - letters);
    }
    return joints;
}

#ifndef SWITCHKINS_TYPES_ONLY
static char *coordinates;
RTAPI_MP_STRING(coordinates, "letters of the axes, one for each joint");
static char *sparm;
RTAPI_MP_STRING(sparm, "text for the kinematics of this module");

static struct {
    KS setup[SWITCHKINS_MAX_TYPES];
    KF forward[SWITCHKINS_MAX_TYPES];
    KI inverse[SWITCHKINS_MAX_TYPES];
    hal_bit_t **is_type[SWITCHKINS_MAX_TYPES];
    int component, type;
} switchkins;

static int switchkins_fail(int code)
{
    hal_exit(switchkins.component);
    return code;
}

int rtapi_app_main(void)
{
    kparms parms;
    memset(&parms, 0, sizeof parms);
    parms.sparm = sparm;
    parms.max_joints = 16;
    KS *s = switchkins.setup;
    KF *f = switchkins.forward;
    KI *i = switchkins.inverse;
    int code = switchkinsSetup(&parms, &s[0], &s[1], &s[2], &f[0], &f[1], &f[2], &i[0], &i[1], &i[2]);
    if (code < 0 || !parms.kinsname || !f[0] || !i[0]) {
        rtapi_print_msg(RTAPI_MSG_ERR, "switchkinsSetup names no kinematics\n");
        return code < 0 ? code : -EINVAL;
    }
    const char *axes = coordinates ? coordinates : parms.required_coordinates;
    const char *needed = parms.required_coordinates;
    for (; coordinates && needed && *needed; needed++)
        if (!strchr(coordinates, toupper(*needed)) && !strchr(coordinates, tolower(*needed))) {
            rtapi_print_msg(RTAPI_MSG_ERR, "%s: coordinates=%s has no '%c'\n", parms.kinsname,
                            coordinates, *needed);
            return -EINVAL;
        }
    switchkins.component = hal_init(parms.kinsname);
    if (switchkins.component < 0)
        return switchkins.component;
    for (int type = 0; type < SWITCHKINS_MAX_TYPES; type++) {
        if (!f[type] || !i[type])
            continue;
        switchkins.is_type[type] = hal_malloc(sizeof(hal_bit_t *));
        if (!switchkins.is_type[type])
            return switchkins_fail(-ENOMEM);
        code = hal_pin_bit_newf(HAL_OUT, switchkins.is_type[type], switchkins.component,
                                "kinstype.is-%d", type);
        if (code == 0 && s[type])
            code = s[type](switchkins.component, axes ? axes : "", &parms);
        if (code < 0)
            return switchkins_fail(code);
        **switchkins.is_type[type] = type == 0;
    }
    return hal_ready(switchkins.component);
}

void rtapi_app_exit(void) { hal_exit(switchkins.component); }

int kinematicsForward(const double *joints, EmcPose *pose, const KINEMATICS_FORWARD_FLAGS *forward,
                      KINEMATICS_INVERSE_FLAGS *inverse)
{
    return switchkins.forward[switchkins.type](joints, pose, forward, inverse);
}

int kinematicsInverse(const EmcPose *pose, double *joints, const KINEMATICS_INVERSE_FLAGS *inverse,
                      KINEMATICS_FORWARD_FLAGS *forward)
{
    return switchkins.inverse[switchkins.type](pose, joints, inverse, forward);
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_BOTH; }
int kinematicsSwitchable(void) { return 1; }

/* Zero, or -1 for a type that the module does not have. */
int kinematicsSwitch(int type)
{
    if (type < 0 || type >= SWITCHKINS_MAX_TYPES || !switchkins.is_type[type])
        return -1;
    **switchkins.is_type[switchkins.type] = 0;
    switchkins.type = type;
    **switchkins.is_type[type] = 1;
    return 0;
}

EXPORT_SYMBOL(kinematicsForward)
EXPORT_SYMBOL(kinematicsInverse)
EXPORT_SYMBOL(kinematicsType)
EXPORT_SYMBOL(kinematicsSwitchable)
EXPORT_SYMBOL(kinematicsSwitch)
#endif
#endif

/* What a kinematics module offers to the motion module. */
#ifndef KINEMATICS_H
#define KINEMATICS_H
#include "emcpos.h"
#include "rtapi_bool.h"

typedef unsigned long int KINEMATICS_FORWARD_FLAGS;
typedef unsigned long int KINEMATICS_INVERSE_FLAGS;

typedef enum {
    KINEMATICS_IDENTITY = 1,
    KINEMATICS_FORWARD_ONLY,
    KINEMATICS_INVERSE_ONLY,
    KINEMATICS_BOTH
} KINEMATICS_TYPE;

#ifdef __cplusplus
extern "C" {
#endif
extern int kinematicsForward(const double *joints, EmcPose *pose,
                             const KINEMATICS_FORWARD_FLAGS *forward,
                             KINEMATICS_INVERSE_FLAGS *inverse);
extern int kinematicsInverse(const EmcPose *pose, double *joints,
                             const KINEMATICS_INVERSE_FLAGS *inverse,
                             KINEMATICS_FORWARD_FLAGS *forward);
extern int kinematicsHome(EmcPose *pose, double *joints, KINEMATICS_FORWARD_FLAGS *forward,
                          KINEMATICS_INVERSE_FLAGS *inverse);
extern KINEMATICS_TYPE kinematicsType(void);
extern int kinematicsSwitchable(void);
extern int kinematicsSwitch(int type);

/* What kinematics tell the code of switchkins.h of themselves. */
typedef struct kinematics_parms {
    /* A text of the user's, from the module parameter sparm. */
    char *sparm;
    char *kinsname;
    /* Prefix of pins. */
    char *halprefix;
    /* Letters of axes that a joint must exist for. */
    char *required_coordinates;
    int max_joints;
    int allow_duplicates;
    int fwd_iterates_mask;
    int gui_kinstype;
} kparms;
#ifdef __cplusplus
}
#endif

#define KINS_NOT_SWITCHABLE                     \
    int kinematicsSwitchable(void) { return 0; } \
    int kinematicsSwitch(int type)              \
    {                                           \
        (void)type;                             \
        return 0;                               \
    }                                           \
    EXPORT_SYMBOL(kinematicsSwitchable)         \
    EXPORT_SYMBOL(kinematicsSwitch)
#endif

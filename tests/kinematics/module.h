/* What modules of kinematics of one type have in common: their exports, and a component without pins of its own. */
#include "hal.h"
#include "kinematics.h"
#include "rtapi.h"
#include "rtapi_app.h"

MODULE_LICENSE("GPL");

/* Solves both ways. */
#define BOTH_WAYS                                                                                 \
    KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_BOTH; }                              \
    KINS_NOT_SWITCHABLE                                                                           \
    EXPORT_SYMBOL(kinematicsForward);                                                             \
    EXPORT_SYMBOL(kinematicsInverse);                                                             \
    EXPORT_SYMBOL(kinematicsType);

/* A component without pins. */
#define COMPONENT(name)                                                                           \
    static int id;                                                                                \
    int rtapi_app_main(void)                                                                      \
    {                                                                                             \
        id = hal_init(name);                                                                      \
        return id < 0 ? id : hal_ready(id);                                                       \
    }                                                                                             \
    void rtapi_app_exit(void) { hal_exit(id); }

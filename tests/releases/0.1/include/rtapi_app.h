/* The two entry points of a component. */
#ifndef RTAPI_APP_H
#define RTAPI_APP_H
#include "rtapi.h"

#ifdef __cplusplus
extern "C" {
#endif
/* Makes the component: zero, or a negative error number after hal_exit. */
extern int rtapi_app_main(void) RTAPI_VISIBLE;
/* Ends it. */
extern void rtapi_app_exit(void) RTAPI_VISIBLE;
#ifdef __cplusplus
}
#endif

RTAPI_EXPORTED(rtapi_app_main)
RTAPI_EXPORTED(rtapi_app_exit)
#endif

/* Error numbers: those of the system. */
#ifndef RTAPI_ERRNO_H
#define RTAPI_ERRNO_H
#include <errno.h>
#endif

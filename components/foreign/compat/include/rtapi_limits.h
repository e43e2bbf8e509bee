/* Limits of numbers: those of the system. */
#ifndef RTAPI_LIMITS_H
#define RTAPI_LIMITS_H
#include <limits.h>
#endif

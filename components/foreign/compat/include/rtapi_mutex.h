/* A lock over one word: who finds it taken gives the processor away and tries again. Not for
 * realtime functions. */
#ifndef RTAPI_MUTEX_H
#define RTAPI_MUTEX_H
#include <sched.h>
#include "rtapi_bitops.h"

typedef unsigned long rtapi_mutex_t;

/* Zero: it is mine now. */
static inline int rtapi_mutex_try(rtapi_mutex_t *lock)
{
    return rtapi_test_and_set_bit(0, lock);
}

static inline void rtapi_mutex_get(rtapi_mutex_t *lock)
{
    while (rtapi_mutex_try(lock))
        sched_yield();
}

static inline void rtapi_mutex_give(rtapi_mutex_t *lock)
{
    rtapi_clear_bit(0, lock);
}
#endif

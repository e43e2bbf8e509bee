/* Memory for set-up: that of the C library. Nothing of it belongs in a realtime function. */
#ifndef RTAPI_SLAB_H
#define RTAPI_SLAB_H
#include <stdlib.h>
#include "rtapi_gfp.h"

static inline void *rtapi_kmalloc(size_t size, rtapi_gfp_t flags)
{
    (void)flags;
    return malloc(size);
}

static inline void *rtapi_kzalloc(size_t size, rtapi_gfp_t flags)
{
    (void)flags;
    return calloc(1, size);
}

static inline void *rtapi_krealloc(void *old, size_t size, rtapi_gfp_t flags)
{
    (void)flags;
    return realloc(old, size);
}

static inline void rtapi_kfree(void *memory)
{
    free(memory);
}
#endif

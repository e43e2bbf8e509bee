/* What programs with pins need that only C can say: functions with a variable number of arguments.
 * Compiled with each program; all else is in libferrule_client.so. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "hal.h"

extern int ferrule_client_item(int component, int type, int dir, void **place, void *at,
                               unsigned long long initial, const char *name);

static int level = RTAPI_MSG_ERR;

int rtapi_set_msg_level(int to)
{
    level = to;
    return 0;
}

int rtapi_get_msg_level(void)
{
    return level;
}

void rtapi_print(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vfprintf(stdout, format, list);
    va_end(list);
    fflush(stdout);
}

void rtapi_print_msg(msg_level_t of, const char *format, ...)
{
    va_list list;
    if ((int)of > level && of != RTAPI_MSG_ALL) return;
    va_start(list, format);
    vfprintf(stderr, format, list);
    va_end(list);
}

int rtapi_vsnprintf(char *to, unsigned long size, const char *format, va_list list)
{
    return vsnprintf(to, size, format, list);
}

int rtapi_snprintf(char *to, unsigned long size, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int length = vsnprintf(to, size, format, list);
    va_end(list);
    return length;
}

long long rtapi_get_time(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000000000LL + now.tv_nsec;
}

long long rtapi_get_clocks(void)
{
    return rtapi_get_time();
}

/* The longest wait in place, in nanoseconds. */
long rtapi_delay_max(void)
{
    return 10000;
}

void rtapi_delay(long ns)
{
    long long end = rtapi_get_time() + (ns < rtapi_delay_max() ? ns : rtapi_delay_max());
    while (rtapi_get_time() < end) { }
}

/* A program is outside the kernel, and in no realtime thread. */
int rtapi_is_kernelspace(void)
{
    return 0;
}

int rtapi_is_realtime(void)
{
    return 0;
}

long simple_strtol(const char *text, char **end, int base)
{
    return strtol(text, end, base);
}

/* The name that a format and its arguments make. */
#define NAMED(name, format)                                                             \
    char name[HAL_NAME_LEN + 1];                                                        \
    {                                                                                   \
        va_list list;                                                                   \
        va_start(list, format);                                                         \
        int length = vsnprintf(name, sizeof(name), format, list);                       \
        va_end(list);                                                                   \
        if (length < 0 || length > HAL_NAME_LEN) {                                      \
            rtapi_print_msg(RTAPI_MSG_ERR, "%s...: this name is too long\n", name);     \
            return -ENOMEM;                                                             \
        }                                                                               \
    }

#define CLASSIC(T, type)                                                                \
    int hal_pin_##T##_new(const char *name, hal_pin_dir_t dir, hal_##T##_t **place, int component) \
    {                                                                                   \
        return ferrule_client_item(component, type, dir, (void **)place, 0, 0, name);   \
    }                                                                                   \
    int hal_param_##T##_new(const char *name, hal_param_dir_t dir, hal_##T##_t *at, int component) \
    {                                                                                   \
        return ferrule_client_item(component, type, dir, 0, (void *)at, 0, name);       \
    }                                                                                   \
    int hal_pin_##T##_newf(hal_pin_dir_t dir, hal_##T##_t **place, int component,       \
                           const char *format, ...)                                     \
    {                                                                                   \
        NAMED(name, format)                                                             \
        return hal_pin_##T##_new(name, dir, place, component);                          \
    }                                                                                   \
    int hal_param_##T##_newf(hal_param_dir_t dir, hal_##T##_t *at, int component,       \
                             const char *format, ...)                                   \
    {                                                                                   \
        NAMED(name, format)                                                             \
        return hal_param_##T##_new(name, dir, at, component);                           \
    }
CLASSIC(bit, HAL_BIT)
CLASSIC(float, HAL_FLOAT)
CLASSIC(s32, HAL_S32)
CLASSIC(u32, HAL_U32)
CLASSIC(s64, HAL_S64)
CLASSIC(u64, HAL_U64)

#define HANDLE(X, handle, value_t, type)                                                \
    int hal_pin_new_##X(int component, hal_pin_dir_t dir, handle *place, value_t value, \
                        const char *format, ...)                                        \
    {                                                                                   \
        NAMED(name, format)                                                             \
        unsigned long long initial = 0;                                                 \
        memcpy(&initial, &value, sizeof(value));                                        \
        return ferrule_client_item(component, type, dir, (void **)place, 0, initial, name); \
    }                                                                                   \
    int hal_param_new_##X(int component, hal_param_dir_t dir, handle *place, value_t value, \
                          const char *format, ...)                                      \
    {                                                                                   \
        NAMED(name, format)                                                             \
        unsigned long long initial = 0;                                                 \
        memcpy(&initial, &value, sizeof(value));                                        \
        return ferrule_client_item(component, type, dir, (void **)place, 0, initial, name); \
    }
HANDLE(bool, hal_bool_t, rtapi_bool, HAL_BIT)
HANDLE(real, hal_real_t, rtapi_real, HAL_FLOAT)
HANDLE(si32, hal_sint_t, rtapi_s32, HAL_S32)
HANDLE(ui32, hal_uint_t, rtapi_u32, HAL_U32)
HANDLE(sint, hal_sint_t, rtapi_sint, HAL_S64)
HANDLE(uint, hal_uint_t, rtapi_uint, HAL_U64)

int hal_param_new_fake(int component, hal_refs_u *place)
{
    (void)component;
    place->p = hal_malloc(8);
    return 0;
}

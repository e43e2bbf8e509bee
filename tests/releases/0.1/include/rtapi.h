/* The realtime interface for components in C: messages, time, memory, parameters of modules.
 *
 * A component defines RTAPI; a program of its own, with pins, defines ULAPI. */
#ifndef RTAPI_H
#define RTAPI_H

#if defined(RTAPI) && defined(ULAPI)
#error "RTAPI (a component) and ULAPI (a program) exclude each other"
#endif
#if !defined(RTAPI) && !defined(ULAPI)
#define RTAPI 1
#endif

#include <stdarg.h>
#include <stddef.h>
#include "rtapi_errno.h"
#include "rtapi_stdint.h"

#define RTAPI_NAME_LEN 31

/* What others find in the file, also where it is compiled with hidden symbols. */
#define RTAPI_VISIBLE __attribute__((visibility("default")))
#define RTAPI_PRINTF(text, first) __attribute__((__format__(__printf__, text, first)))
/* Lists the symbol for the build, which may make all others local. */
#define RTAPI_EXPORTED(name)                                                            \
    static const char rtapi_exported_##name[]                                           \
        __attribute__((section(".rtapi_export"), used)) = #name;

#ifdef __cplusplus
#define RTAPI_BEGIN_DECLS extern "C" {
#define RTAPI_END_DECLS }
#else
#define RTAPI_BEGIN_DECLS
#define RTAPI_END_DECLS
#endif

#ifdef __cplusplus
extern "C" {
#endif

extern int rtapi_init(const char *name);
extern int rtapi_exit(int module);

/* As those of the C library. */
extern int rtapi_snprintf(char *to, unsigned long size, const char *format, ...)
    RTAPI_PRINTF(3, 4);
extern int rtapi_vsnprintf(char *to, unsigned long size, const char *format, va_list list)
    RTAPI_PRINTF(3, 0);

typedef enum {
    RTAPI_MSG_NONE = 0,
    RTAPI_MSG_ERR,
    RTAPI_MSG_WARN,
    RTAPI_MSG_INFO,
    RTAPI_MSG_DBG,
    RTAPI_MSG_ALL
} msg_level_t;

/* Messages go to the engine's log; from a realtime function, through a queue. */
extern void rtapi_print(const char *format, ...) RTAPI_PRINTF(1, 2);
extern void rtapi_print_msg(msg_level_t level, const char *format, ...) RTAPI_PRINTF(2, 3);
extern int rtapi_set_msg_level(int level);
extern int rtapi_get_msg_level(void);
typedef void (*rtapi_msg_handler_t)(msg_level_t level, const char *format, va_list list);
extern void rtapi_set_msg_handler(rtapi_msg_handler_t handler);
extern rtapi_msg_handler_t rtapi_get_msg_handler(void);

/* Machine time in nanoseconds. Under the virtual clock it stands still within a function. */
extern long long int rtapi_get_time(void);
/* The same, for code that counts cycles of the processor: one is a nanosecond. */
extern long long int rtapi_get_clocks(void);
/* Waits in place, at most rtapi_delay_max() nanoseconds; under the virtual clock, not at all. */
extern void rtapi_delay(long int nsec);
extern long int rtapi_delay_max(void);
extern long int rtapi_clock_set_period(long int nsec);

typedef enum {
    REALTIME_TYPE_UNINITIALIZED = -1,
    REALTIME_TYPE_NONE = 0,
    REALTIME_TYPE_UNKNOWN,
    REALTIME_TYPE_PREEMPT_DYNAMIC,
    REALTIME_TYPE_PREEMPT_RT,
    REALTIME_TYPE_RTAI,
    REALTIME_TYPE_LXRT,
    REALTIME_TYPE_XENOMAI,
    REALTIME_TYPE_XENOMAI_EVL
} rtapi_realtime_type_t;
extern int rtapi_is_kernelspace(void);
extern int rtapi_is_realtime(void);
extern int rtapi_get_realtime_type(void);

/* Memory that several components share by a key; new memory is all zero. */
extern int rtapi_shmem_new(int key, int module, unsigned long size);
extern int rtapi_shmem_getptr(int id, void **place);
extern int rtapi_shmem_delete(int id, int module);

/* Priorities, and tasks of a component's own: threads are the engine's (hal_create_thread), so
 * making a task is refused. */
extern int rtapi_prio_highest(void);
extern int rtapi_prio_lowest(void);
extern int rtapi_prio_next_higher(int priority);
extern int rtapi_prio_next_lower(int priority);
extern int rtapi_task_new(void (*code)(void *), void *arg, int priority, int owner,
                          unsigned long stack, int uses_fp);
extern int rtapi_task_delete(int task);
extern int rtapi_task_start(int task, unsigned long period_ns);
extern int rtapi_task_pause(int task);
extern int rtapi_task_resume(int task);
extern int rtapi_task_self(void);
extern int rtapi_task_self_resync(void);
extern void rtapi_wait(void);
extern long long int rtapi_task_pll_get_reference(void);
extern int rtapi_task_pll_set_correction(long int ns);

extern int rtapi_open_as_root(const char *path, int mode);
extern int rtapi_spawn_as_root(int *pid, const char *path, const void *actions,
                               const void *attributes, char *const arguments[],
                               char *const environment[]);
extern int rtapi_spawnp_as_root(int *pid, const char *path, const void *actions,
                                const void *attributes, char *const arguments[],
                                char *const environment[]);

extern long int simple_strtol(const char *text, char **end, int base);

#ifdef __cplusplus
}
#endif

#include "rtapi_io.h"

/* What a module says of itself: symbols that a loader reads without running anything. */
#ifdef RTAPI
#define RTAPI_INFO_TEXT(name, text) \
    RTAPI_VISIBLE const char *rtapi_info_##name = text;
#define RTAPI_INFO_VALUE(variable, letter, text)                                        \
    RTAPI_VISIBLE const char *rtapi_info_type_##variable = letter;                      \
    RTAPI_VISIBLE const char *rtapi_info_description_##variable = text;
#define RTAPI_INFO_SINGLE(variable, letter, text)                                       \
    RTAPI_INFO_VALUE(variable, letter, text)                                            \
    RTAPI_VISIBLE void *rtapi_info_address_##variable = &variable;
#define RTAPI_INFO_ARRAY(variable, letter, count, text)                                 \
    RTAPI_INFO_VALUE(variable, letter, text)                                            \
    RTAPI_VISIBLE void *rtapi_info_address_##variable = variable;                       \
    RTAPI_VISIBLE int rtapi_info_size_##variable = count;
#define RTAPI_INFO_LINED(tag, line, text) RTAPI_INFO_LINED_(tag, line, text)
#define RTAPI_INFO_LINED_(tag, line, text) \
    RTAPI_VISIBLE const char *rtapi_info_##tag##_##line = text;

#define MODULE_LICENSE(text) RTAPI_INFO_TEXT(license, text)
#define MODULE_AUTHOR(text) RTAPI_INFO_TEXT(author, text)
#define MODULE_DESCRIPTION(text) RTAPI_INFO_TEXT(description, text)
#define MODULE_SUPPORTED_DEVICE(text) RTAPI_INFO_TEXT(supported_device, text)
#define MODULE_DEVICE_TABLE(bus, table)
#define MODULE_INFO(tag, text) RTAPI_INFO_LINED(tag, __LINE__, text)

#define RTAPI_MP_INT(variable, text) RTAPI_INFO_SINGLE(variable, "i", text)
#define RTAPI_MP_LONG(variable, text) RTAPI_INFO_SINGLE(variable, "l", text)
#define RTAPI_MP_STRING(variable, text) RTAPI_INFO_SINGLE(variable, "s", text)
#define RTAPI_MP_ARRAY_INT(variable, count, text) RTAPI_INFO_ARRAY(variable, "i", count, text)
#define RTAPI_MP_ARRAY_LONG(variable, count, text) RTAPI_INFO_ARRAY(variable, "l", count, text)
#define RTAPI_MP_ARRAY_STRING(variable, count, text) RTAPI_INFO_ARRAY(variable, "s", count, text)

/* Others may use the symbol. */
#define EXPORT_SYMBOL(name)                                                             \
    extern __typeof__(name) name RTAPI_VISIBLE;                                         \
    RTAPI_EXPORTED(name)
#define EXPORT_SYMBOL_GPL(name) EXPORT_SYMBOL(name)
/* Another component in C, which is loaded before, exports the symbol. */
#define RTAPI_IMPORT_SYMBOL(name)                                                       \
    static const char rtapi_imported_##name[]                                           \
        __attribute__((section(".rtapi_import"), used)) = #name;
#else
#define MODULE_LICENSE(text)
#define MODULE_AUTHOR(text)
#define MODULE_DESCRIPTION(text)
#define MODULE_SUPPORTED_DEVICE(text)
#define MODULE_DEVICE_TABLE(bus, table)
#define MODULE_INFO(tag, text)
#define RTAPI_MP_INT(variable, text)
#define RTAPI_MP_LONG(variable, text)
#define RTAPI_MP_STRING(variable, text)
#define RTAPI_MP_ARRAY_INT(variable, count, text)
#define RTAPI_MP_ARRAY_LONG(variable, count, text)
#define RTAPI_MP_ARRAY_STRING(variable, count, text)
#define EXPORT_SYMBOL(name)
#define EXPORT_SYMBOL_GPL(name)
#define RTAPI_IMPORT_SYMBOL(name)
#endif

#endif

/* The interface of components in C: pins, parameters, functions.
 *
 * Both generations of names are here: hal_pin_bit_new(f) and its kin, where the component holds a
 * pointer to the value; and hal_pin_new_bool and its kin, where it holds a handle. */
#ifndef HAL_H
#define HAL_H

#include "rtapi.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAL_NAME_LEN 55
#define HAL_STREAM_MAX_PINS 21
#define HAL_PORT_SIZE_MAX 65536

#define HAL_LOCK_NONE 0
#define HAL_LOCK_LOAD 1
#define HAL_LOCK_CONFIG 2
#define HAL_LOCK_PARAMS 4
#define HAL_LOCK_RUN 8
#define HAL_LOCK_TUNE (HAL_LOCK_LOAD | HAL_LOCK_CONFIG)
#define HAL_LOCK_ALL 255

typedef enum {
    HAL_TYPE_UNSPECIFIED = -1,
    HAL_TYPE_UNINITIALIZED = 0,
    HAL_BIT = 1,
    HAL_FLOAT = 2,
    HAL_S32 = 3,
    HAL_U32 = 4,
    HAL_PORT = 5,
    HAL_S64 = 6,
    HAL_U64 = 7,
    HAL_TYPE_MAX = 8
} hal_type_t;
#define HAL_BOOL HAL_BIT
#define HAL_REAL HAL_FLOAT
#define HAL_SINT HAL_S64
#define HAL_UINT HAL_U64

typedef enum {
    HAL_DIR_UNSPECIFIED = -1,
    HAL_IN = 16,
    HAL_OUT = 32,
    HAL_IO = (HAL_IN | HAL_OUT)
} hal_pin_dir_t;

typedef enum {
    HAL_RO = 64,
    HAL_WO = 128,
    HAL_RW = (HAL_RO | HAL_WO)
} hal_param_dir_t;

typedef enum {
    COMPONENT_TYPE_UNKNOWN = -1,
    COMPONENT_TYPE_USER = 0,
    COMPONENT_TYPE_REALTIME = 1,
    COMPONENT_TYPE_OTHER = 2
} component_type_t;

typedef volatile bool hal_bit_t;
typedef volatile rtapi_s32 hal_s32_t;
typedef volatile rtapi_u32 hal_u32_t;
typedef volatile rtapi_s64 hal_s64_t;
typedef volatile rtapi_u64 hal_u64_t;
typedef volatile real_t hal_float_t;
/* A byte queue: the number by which the functions below find it. */
typedef volatile int hal_port_t;

typedef union {
    hal_bit_t b;
    hal_s32_t s;
    hal_u32_t u;
    hal_float_t f;
    hal_port_t p;
    hal_s64_t ls;
    hal_u64_t lu;
} hal_data_u;

/* The handles of the new interface. */
typedef struct hal_bool_value *hal_bool_t;
typedef struct hal_sint_value *hal_sint_t;
typedef struct hal_uint_value *hal_uint_t;
typedef struct hal_real_value *hal_real_t;
typedef union {
    hal_bool_t b;
    hal_sint_t s;
    hal_uint_t u;
    hal_real_t r;
    void *p;
} hal_refs_u;

/* The component. */
extern int hal_init(const char *name);
extern int hal_exit(int component);
extern int hal_ready(int component);
extern int hal_unready(int component);
extern int hal_set_unready(int component);
/* Zeroed memory that goes with the component. Pointers to pins, and parameters, live here. */
extern void *hal_malloc(long int size);
extern char *hal_comp_name(int component);
extern const char *hal_strerror(int error);
extern rtapi_realtime_type_t hal_get_realtime_type(void);
extern int hal_set_lock(unsigned char level);
extern unsigned char hal_get_lock(void);
typedef int (*constructor)(const char *prefix, const char *arg);
extern int hal_set_constructor(int component, constructor make);

/* Pins: *place is set to where the value is, and set again when the pin is linked. */
extern int hal_pin_bit_new(const char *name, hal_pin_dir_t dir, hal_bit_t **place, int component);
extern int hal_pin_float_new(const char *name, hal_pin_dir_t dir, hal_float_t **place, int component);
extern int hal_pin_s32_new(const char *name, hal_pin_dir_t dir, hal_s32_t **place, int component);
extern int hal_pin_u32_new(const char *name, hal_pin_dir_t dir, hal_u32_t **place, int component);
extern int hal_pin_s64_new(const char *name, hal_pin_dir_t dir, hal_s64_t **place, int component);
extern int hal_pin_u64_new(const char *name, hal_pin_dir_t dir, hal_u64_t **place, int component);
extern int hal_pin_port_new(const char *name, hal_pin_dir_t dir, hal_port_t **place, int component);
extern int hal_pin_bit_newf(hal_pin_dir_t dir, hal_bit_t **place, int component, const char *format,
                            ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_float_newf(hal_pin_dir_t dir, hal_float_t **place, int component,
                              const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_s32_newf(hal_pin_dir_t dir, hal_s32_t **place, int component, const char *format,
                            ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_u32_newf(hal_pin_dir_t dir, hal_u32_t **place, int component, const char *format,
                            ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_s64_newf(hal_pin_dir_t dir, hal_s64_t **place, int component, const char *format,
                            ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_u64_newf(hal_pin_dir_t dir, hal_u64_t **place, int component, const char *format,
                            ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_port_newf(hal_pin_dir_t dir, hal_port_t **place, int component,
                             const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_pin_new(const char *name, hal_type_t type, hal_pin_dir_t dir, void **place,
                       int component);
extern int hal_pin_alias(const char *pin, const char *alias);

#ifdef ULAPI
/* Value of any component's pin, of a signal, or of a parameter, at the time of the call: *data is a copy, which only
 * the next call for this name renews. 0, or -1 if there is none. connected: the pin is linked; has_writers: an output
 * is linked to the signal. A component has pins of its own instead, and a net links them. */
extern int hal_get_pin_value_by_name(const char *name, hal_type_t *type, hal_data_u **data,
                                     bool *connected);
extern int hal_get_signal_value_by_name(const char *name, hal_type_t *type, hal_data_u **data,
                                        bool *has_writers);
extern int hal_get_param_value_by_name(const char *name, hal_type_t *type, hal_data_u **data);
#endif

/* Parameters: the value lives at place, which is the component's. */
extern int hal_param_bit_new(const char *name, hal_param_dir_t dir, hal_bit_t *place, int component);
extern int hal_param_float_new(const char *name, hal_param_dir_t dir, hal_float_t *place,
                               int component);
extern int hal_param_s32_new(const char *name, hal_param_dir_t dir, hal_s32_t *place, int component);
extern int hal_param_u32_new(const char *name, hal_param_dir_t dir, hal_u32_t *place, int component);
extern int hal_param_s64_new(const char *name, hal_param_dir_t dir, hal_s64_t *place, int component);
extern int hal_param_u64_new(const char *name, hal_param_dir_t dir, hal_u64_t *place, int component);
extern int hal_param_bit_newf(hal_param_dir_t dir, hal_bit_t *place, int component,
                              const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_param_float_newf(hal_param_dir_t dir, hal_float_t *place, int component,
                                const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_param_s32_newf(hal_param_dir_t dir, hal_s32_t *place, int component,
                              const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_param_u32_newf(hal_param_dir_t dir, hal_u32_t *place, int component,
                              const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_param_s64_newf(hal_param_dir_t dir, hal_s64_t *place, int component,
                              const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_param_u64_newf(hal_param_dir_t dir, hal_u64_t *place, int component,
                              const char *format, ...) RTAPI_PRINTF(4, 5);
extern int hal_param_new(const char *name, hal_type_t type, hal_param_dir_t dir, volatile void *place,
                         int component);
extern int hal_param_alias(const char *param, const char *alias);
extern int hal_param_bit_set(const char *name, int value);
extern int hal_param_float_set(const char *name, double value);
extern int hal_param_s32_set(const char *name, signed long value);
extern int hal_param_u32_set(const char *name, unsigned long value);
extern int hal_param_set(const char *name, hal_type_t type, void *value);

/* Signals and links. */
extern int hal_signal_new(const char *name, hal_type_t type);
extern int hal_signal_delete(const char *name);
extern int hal_link(const char *pin, const char *signal);
extern int hal_unlink(const char *pin);

/* Functions and threads. */
extern int hal_export_funct(const char *name, void (*code)(void *, long), void *arg, int uses_fp,
                            int reentrant, int component);
extern int hal_export_functf(void (*code)(void *, long), void *arg, int uses_fp, int reentrant,
                             int component, const char *format, ...) RTAPI_PRINTF(6, 7);
extern int hal_create_thread(const char *name, unsigned long period_ns, int uses_fp);
extern int hal_thread_delete(const char *name);
extern int hal_add_funct_to_thread(const char *funct, const char *thread, int position);
extern int hal_init_funct_to_thread(const char *funct, const char *thread, int position);
extern int hal_del_funct_from_thread(const char *funct, const char *thread);
extern int hal_start_threads(void);
extern int hal_stop_threads(void);

/* The new interface. A handle lives in hal_malloc memory; its value is always 64 bits wide. */
extern int hal_pin_new_bool(int component, hal_pin_dir_t dir, hal_bool_t *place, rtapi_bool value,
                            const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_pin_new_si32(int component, hal_pin_dir_t dir, hal_sint_t *place, rtapi_s32 value,
                            const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_pin_new_ui32(int component, hal_pin_dir_t dir, hal_uint_t *place, rtapi_u32 value,
                            const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_pin_new_sint(int component, hal_pin_dir_t dir, hal_sint_t *place, rtapi_sint value,
                            const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_pin_new_uint(int component, hal_pin_dir_t dir, hal_uint_t *place, rtapi_uint value,
                            const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_pin_new_real(int component, hal_pin_dir_t dir, hal_real_t *place, rtapi_real value,
                            const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_pin_new_port(int component, hal_pin_dir_t dir, hal_sint_t *place, const char *format,
                            ...) RTAPI_PRINTF(4, 5);
extern int hal_param_new_bool(int component, hal_param_dir_t dir, hal_bool_t *place, rtapi_bool value,
                              const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_param_new_si32(int component, hal_param_dir_t dir, hal_sint_t *place, rtapi_s32 value,
                              const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_param_new_ui32(int component, hal_param_dir_t dir, hal_uint_t *place, rtapi_u32 value,
                              const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_param_new_sint(int component, hal_param_dir_t dir, hal_sint_t *place, rtapi_sint value,
                              const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_param_new_uint(int component, hal_param_dir_t dir, hal_uint_t *place, rtapi_uint value,
                              const char *format, ...) RTAPI_PRINTF(5, 6);
extern int hal_param_new_real(int component, hal_param_dir_t dir, hal_real_t *place, rtapi_real value,
                              const char *format, ...) RTAPI_PRINTF(5, 6);
/* A value that nobody sees. */
extern int hal_param_new_fake(int component, hal_refs_u *place);

static inline rtapi_u64 hal_value_load(const void *handle)
{
    return __atomic_load_n((const rtapi_u64 *)handle, __ATOMIC_ACQUIRE);
}

static inline void hal_value_store(void *handle, rtapi_u64 bits)
{
    __atomic_store_n((rtapi_u64 *)handle, bits, __ATOMIC_RELEASE);
}

static inline rtapi_bool hal_get_bool(const hal_bool_t handle)
{
    return (hal_value_load(handle) & 0xff) != 0;
}

static inline rtapi_bool hal_set_bool(hal_bool_t handle, rtapi_bool value)
{
    hal_value_store(handle, value ? 1 : 0);
    return value;
}

static inline rtapi_real hal_get_real(const hal_real_t handle)
{
    union {
        rtapi_u64 bits;
        rtapi_real value;
    } both;
    both.bits = hal_value_load(handle);
    return both.value;
}

static inline rtapi_real hal_set_real(hal_real_t handle, rtapi_real value)
{
    union {
        rtapi_u64 bits;
        rtapi_real value;
    } both;
    both.value = value;
    hal_value_store(handle, both.bits);
    return value;
}

static inline rtapi_sint hal_get_sint(const hal_sint_t handle)
{
    return (rtapi_sint)hal_value_load(handle);
}

static inline rtapi_sint hal_set_sint(hal_sint_t handle, rtapi_sint value)
{
    hal_value_store(handle, (rtapi_u64)value);
    return value;
}

static inline rtapi_uint hal_get_uint(const hal_uint_t handle)
{
    return hal_value_load(handle);
}

static inline rtapi_uint hal_set_uint(hal_uint_t handle, rtapi_uint value)
{
    hal_value_store(handle, value);
    return value;
}

/* 32-bit values: the low half counts. */
static inline rtapi_s32 hal_get_si32(const hal_sint_t handle)
{
    return (rtapi_s32)(rtapi_u32)hal_value_load(handle);
}

static inline rtapi_s32 hal_set_si32(hal_sint_t handle, rtapi_s32 value)
{
    hal_value_store(handle, (rtapi_u64)(rtapi_s64)value);
    return value;
}

static inline rtapi_u32 hal_get_ui32(const hal_uint_t handle)
{
    return (rtapi_u32)hal_value_load(handle);
}

static inline rtapi_u32 hal_set_ui32(hal_uint_t handle, rtapi_u32 value)
{
    hal_value_store(handle, value);
    return value;
}

static inline rtapi_s32 hal_get_si32_clamped(const hal_sint_t handle)
{
    rtapi_sint value = hal_get_sint(handle);
    return value > INT32_MAX ? INT32_MAX : value < INT32_MIN ? INT32_MIN : (rtapi_s32)value;
}

static inline rtapi_u32 hal_get_ui32_clamped(const hal_uint_t handle)
{
    rtapi_uint value = hal_get_uint(handle);
    return value > UINT32_MAX ? UINT32_MAX : (rtapi_u32)value;
}

/* Follows a counter of nbits bits that wraps: old, moved by how far its low bits have moved. */
static inline rtapi_s64 hal_extend_counter(rtapi_s64 old, rtapi_s64 low, int nbits)
{
    int rest = 64 - nbits;
    rtapi_u64 moved = ((rtapi_u64)low - (rtapi_u64)old) << rest;
    return (rtapi_s64)((rtapi_u64)old + (rtapi_u64)((rtapi_s64)moved >> rest));
}

/* Streams of samples: one writes, one reads. */
union hal_stream_data {
    real_t f;
    bool b;
    rtapi_s32 s;
    rtapi_u32 u;
    rtapi_s64 l;
    rtapi_u64 k;
};
typedef struct hal_stream {
    int comp_id;
    int shmem_id;
    void *fifo;
} hal_stream_t;
extern int hal_stream_create(hal_stream_t *stream, int component, int key, unsigned depth,
                             const char *types);
extern void hal_stream_destroy(hal_stream_t *stream);
extern int hal_stream_attach(hal_stream_t *stream, int component, int key, const char *types);
extern int hal_stream_detach(hal_stream_t *stream);
extern int hal_stream_element_count(hal_stream_t *stream);
extern hal_type_t hal_stream_element_type(hal_stream_t *stream, int index);
extern int hal_stream_read(hal_stream_t *stream, union hal_stream_data *values, unsigned *sample);
extern bool hal_stream_readable(hal_stream_t *stream);
extern int hal_stream_depth(hal_stream_t *stream);
extern unsigned hal_stream_maxdepth(hal_stream_t *stream);
extern int hal_stream_num_underruns(hal_stream_t *stream);
extern int hal_stream_num_overruns(hal_stream_t *stream);
extern int hal_stream_write(hal_stream_t *stream, union hal_stream_data *values);
extern bool hal_stream_writable(hal_stream_t *stream);

/* Ports: byte queues, all or nothing. */
extern bool hal_port_read(hal_port_t port, char *to, unsigned count);
extern bool hal_port_peek(hal_port_t port, char *to, unsigned count);
extern bool hal_port_peek_commit(hal_port_t port, unsigned count);
extern unsigned hal_port_readable(hal_port_t port);
extern void hal_port_clear(hal_port_t port);
extern bool hal_port_write(hal_port_t port, const char *from, unsigned count);
extern unsigned hal_port_writable(hal_port_t port);
extern unsigned hal_port_buffer_size(hal_port_t port);

#ifdef __cplusplus
}
#endif
#endif

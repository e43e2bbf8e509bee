/* What only C can say: functions with any number of arguments, and one variable for each thread.
 *
 * Every function here is called ferrule_c_NAME; variadic.rs exports it as NAME. */
#include <stdio.h>
#include "hal.h"
#include "motion.h"
#include <stddef.h>

/* The function that runs, as running.rs has it. */
struct running {
    void (*code)(void *, long);
    void *arg;
    const void *module;
};

static __thread const struct running *current __attribute__((tls_model("initial-exec")));

const struct running *ferrule_current(void)
{
    return current;
}

const struct running *ferrule_swap(const struct running *next)
{
    const struct running *before = current;
    current = next;
    return before;
}

/* Realtime. Runs a component's function once. */
int ferrule_run(void *state, int64_t period)
{
    const struct running *me = state;
    current = me;
    me->code(me->arg, (long)period);
    current = NULL;
    return 0;
}

/* Messages. */
extern void ferrule_say(int level, const char *text);

static void to_the_log(msg_level_t level, const char *format, va_list list)
{
    char text[1024];
    if (vsnprintf(text, sizeof text, format, list) >= 0)
        ferrule_say(level, text);
}

static rtapi_msg_handler_t handler = to_the_log;

void ferrule_c_rtapi_set_msg_handler(rtapi_msg_handler_t next)
{
    __atomic_store_n(&handler, next ? next : to_the_log, __ATOMIC_RELEASE);
}

rtapi_msg_handler_t ferrule_c_rtapi_get_msg_handler(void)
{
    return __atomic_load_n(&handler, __ATOMIC_ACQUIRE);
}

/* Who speaks now, and that again who did at first. */
const void *ferrule_handler(void)
{
    union {
        rtapi_msg_handler_t code;
        const void *address;
    } both = { ferrule_c_rtapi_get_msg_handler() };
    return both.address;
}

void ferrule_default_handler(void)
{
    ferrule_c_rtapi_set_msg_handler(NULL);
}

void ferrule_c_rtapi_print(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    ferrule_c_rtapi_get_msg_handler()(RTAPI_MSG_ALL, format, list);
    va_end(list);
}

void ferrule_c_rtapi_print_msg(msg_level_t level, const char *format, ...)
{
    if ((int)level > rtapi_get_msg_level())
        return;
    va_list list;
    va_start(list, format);
    ferrule_c_rtapi_get_msg_handler()(level, format, list);
    va_end(list);
}

int ferrule_c_rtapi_snprintf(char *to, unsigned long size, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int length = vsnprintf(to, size, format, list);
    va_end(list);
    return length;
}

int ferrule_c_rtapi_vsnprintf(char *to, unsigned long size, const char *format, va_list list)
{
    return vsnprintf(to, size, format, list);
}

/* Names as with printf. The longest name and its end fit; what is longer is refused by name. */
#define NAME_SIZE 128
#define NAMED(call)                                          \
    char name[NAME_SIZE];                                    \
    va_list list;                                            \
    va_start(list, format);                                  \
    int length = vsnprintf(name, sizeof name, format, list); \
    va_end(list);                                            \
    if (length < 0)                                          \
        return -EINVAL;                                      \
    return call;

#define ITEM(kind, letter, ctype, dirtype, stars)                                          \
    int ferrule_c_hal_##kind##_##letter##_newf(dirtype dir, ctype stars place, int component, \
                                               const char *format, ...)                    \
    {                                                                                      \
        NAMED(hal_##kind##_##letter##_new(name, dir, place, component))                    \
    }

ITEM(pin, bit, hal_bit_t, hal_pin_dir_t, **)
ITEM(pin, float, hal_float_t, hal_pin_dir_t, **)
ITEM(pin, s32, hal_s32_t, hal_pin_dir_t, **)
ITEM(pin, u32, hal_u32_t, hal_pin_dir_t, **)
ITEM(pin, s64, hal_s64_t, hal_pin_dir_t, **)
ITEM(pin, u64, hal_u64_t, hal_pin_dir_t, **)
ITEM(pin, port, hal_port_t, hal_pin_dir_t, **)
ITEM(param, bit, hal_bit_t, hal_param_dir_t, *)
ITEM(param, float, hal_float_t, hal_param_dir_t, *)
ITEM(param, s32, hal_s32_t, hal_param_dir_t, *)
ITEM(param, u32, hal_u32_t, hal_param_dir_t, *)
ITEM(param, s64, hal_s64_t, hal_param_dir_t, *)
ITEM(param, u64, hal_u64_t, hal_param_dir_t, *)

int ferrule_c_hal_export_functf(void (*code)(void *, long), void *arg, int uses_fp, int reentrant,
                                int component, const char *format, ...)
{
    NAMED(hal_export_funct(name, code, arg, uses_fp, reentrant, component))
}

/* The new interface: a type code, the bits of the first value, and how names are given. */
extern int ferrule_new_pin(int component, int type, int dir, void **place, uint64_t bits,
                           const char *name);
extern int ferrule_new_param(int component, int type, int dir, void **place, uint64_t bits,
                             const char *name);

static uint64_t bits_of_real(double value)
{
    union {
        double value;
        uint64_t bits;
    } both = { value };
    return both.bits;
}

#define NEW(kind, letter, type, ctype, handle, bits)                                         \
    int ferrule_c_hal_##kind##_new_##letter(int component, hal_##kind##_dir_t dir,           \
                                            handle *place, ctype value, const char *format,  \
                                            ...)                                             \
    {                                                                                        \
        NAMED(ferrule_new_##kind(component, type, dir, (void **)place, bits, name))          \
    }

#define BOTH(letter, type, ctype, handle, bits)      \
    NEW(pin, letter, type, ctype, handle, bits)      \
    NEW(param, letter, type, ctype, handle, bits)

BOTH(si32, HAL_S32, rtapi_s32, hal_sint_t, (uint64_t)(int64_t)value)
BOTH(ui32, HAL_U32, rtapi_u32, hal_uint_t, value)
BOTH(sint, HAL_S64, rtapi_sint, hal_sint_t, (uint64_t)value)
BOTH(uint, HAL_U64, rtapi_uint, hal_uint_t, value)
BOTH(real, HAL_FLOAT, rtapi_real, hal_real_t, bits_of_real(value))
/* Not through BOTH, where bool would become _Bool. */
NEW(pin, bool, HAL_BIT, rtapi_bool, hal_bool_t, value ? 1 : 0)
NEW(param, bool, HAL_BIT, rtapi_bool, hal_bool_t, value ? 1 : 0)

int ferrule_c_hal_pin_new_port(int component, hal_pin_dir_t dir, hal_sint_t *place,
                               const char *format, ...)
{
    NAMED(ferrule_new_pin(component, HAL_PORT, dir, (void **)place, 0, name))
}

/* Layout of the records of joints, for a test of the loader: sizes, places of fields, and a zero. */
#define IN_PLANNER(field) offsetof(simple_tp_t, field)
#define IN_JOINT(field) offsetof(emcmot_joint_t, field)
const unsigned long ferrule_joint_layout[] = {
    sizeof(simple_tp_t),
    IN_PLANNER(pos_cmd), IN_PLANNER(max_vel), IN_PLANNER(max_acc), IN_PLANNER(enable),
    IN_PLANNER(curr_pos), IN_PLANNER(curr_vel), IN_PLANNER(active),
    sizeof(emcmot_joint_t),
    IN_JOINT(max_pos_limit), IN_JOINT(min_pos_limit), IN_JOINT(max_jog_limit),
    IN_JOINT(min_jog_limit), IN_JOINT(vel_limit), IN_JOINT(acc_limit), IN_JOINT(min_ferror),
    IN_JOINT(max_ferror), IN_JOINT(backlash), IN_JOINT(pos_cmd), IN_JOINT(vel_cmd),
    IN_JOINT(acc_cmd), IN_JOINT(backlash_corr), IN_JOINT(backlash_filt), IN_JOINT(backlash_vel),
    IN_JOINT(motor_pos_cmd), IN_JOINT(motor_pos_fb), IN_JOINT(pos_fb), IN_JOINT(ferror),
    IN_JOINT(ferror_limit), IN_JOINT(motor_offset), IN_JOINT(free_tp), IN_JOINT(kb_jjog_active),
    IN_JOINT(wheel_jjog_active), IN_JOINT(on_pos_limit), IN_JOINT(on_neg_limit), IN_JOINT(flag),
    0,
};

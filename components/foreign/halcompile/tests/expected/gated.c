/* Made by halcompile from gated: change that file, not this one. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_string.h"
#include "rtapi_errno.h"
#include "rtapi_math64.h"
#include "hal.h"

static int comp_id;
MODULE_INFO(linuxcnc, "component:gated:Pins and parameters that only some instances have.");
MODULE_INFO(linuxcnc, "pin:in:float:0:in::None:None");
MODULE_INFO(linuxcnc, "pin:out:float:0:out::None:None");
MODULE_INFO(linuxcnc, "pin:offset_:float:0:in:Added.:10:(personality & 1)");
MODULE_INFO(linuxcnc, "param:gain:float:0:rw::2:(personality & 2)");
MODULE_INFO(linuxcnc, "param:seen-#:s32:2:r::7:(personality & 4)");
MODULE_INFO(linuxcnc, "funct:_:1:");
MODULE_INFO(linuxcnc, "license:MIT");
MODULE_LICENSE("MIT");

struct __comp_state {
    struct __comp_state *_next;
    int _personality;
    hal_float_t *in_p;
    hal_float_t *out_p;
    hal_float_t *offset__p;
    hal_float_t gain_p;
    hal_s32_t seen_p[2];
};
static struct __comp_state *__comp_first_inst, *__comp_last_inst;

static void _(struct __comp_state *__comp_inst, long period);

enum { __comp_default_count = 1 };
static int count;
static char *names = "";
RTAPI_MP_INT(count, "How many of gated there are.")
RTAPI_MP_STRING(names, "The names of gated, with commas between them.")
static int personality[64] = {[0 ... 64 - 1] = 0};
RTAPI_MP_ARRAY_INT(personality, 64, "What each of gated is.")

/* Makes an instance: its pins, parameters and functions. */
__attribute__((unused))
static int export(char *prefix, long extra_arg, long personality)
{
    struct __comp_state *made = hal_malloc(sizeof(*made));
    long at, count;
    int rc;
    (void)extra_arg; (void)at; (void)count; (void)rc;
    if (!made) return -ENOMEM;
    memset(made, 0, sizeof(*made));
    made->_personality = personality;
    rc = hal_pin_float_newf(HAL_IN, &made->in_p, comp_id, "%s.in", prefix);
    if (rc != 0) return rc;
    rc = hal_pin_float_newf(HAL_OUT, &made->out_p, comp_id, "%s.out", prefix);
    if (rc != 0) return rc;
    if ((personality & 1)) {
    rc = hal_pin_float_newf(HAL_IN, &made->offset__p, comp_id, "%s.offset", prefix);
    if (rc != 0) return rc;
    *made->offset__p = 10;
    }
    if ((personality & 2)) {
    rc = hal_param_float_newf(HAL_RW, &made->gain_p, comp_id, "%s.gain", prefix);
    if (rc != 0) return rc;
    made->gain_p = 2;
    }
    if ((personality & 4)) {
    count = 2;
    for (at = 0; at < count; at++) {
    rc = hal_param_s32_newf(HAL_RO, &made->seen_p[at], comp_id, "%s.seen-%d", prefix, (int)at);
    if (rc != 0) return rc;
    made->seen_p[at] = 7;
    }
    }
    rc = hal_export_functf((void (*)(void *, long))_, made, 1, 0, comp_id, "%s", prefix);
    if (rc != 0) return rc;
    if (__comp_last_inst) __comp_last_inst->_next = made;
    else __comp_first_inst = made;
    __comp_last_inst = made;
    return 0;
}

static int __comp_make(char *prefix, int index)
{
    if (index >= 64)
        rtapi_print_msg(RTAPI_MSG_ERR, "gated: there are 64 personalities; instance %d takes that of %d\n", index, index % 64);
    return export(prefix, index, personality[index % 64]);
}

static int __comp_make_all(void)
{
    if (names[0] != '\0') {
        const char *rest = names;
        for (int i = 0; rest; i++) {
            char name[HAL_NAME_LEN + 1];
            const char *comma = strchr(rest, ',');
            unsigned long length = comma ? (unsigned long)(comma - rest) : strlen(rest);
            if (length >= sizeof(name)) {
                rtapi_print_msg(RTAPI_MSG_ERR, "names: \"%.*s\" too long\n", (int)length, rest);
                return -EINVAL;
            }
            if (length == 0) {
                rtapi_print_msg(RTAPI_MSG_ERR, "names[%d] is invalid (empty string)\n", i);
                return -EINVAL;
            }
            memcpy(name, rest, length);
            name[length] = '\0';
            int rc = __comp_make(name, i);
            if (rc != 0) return rc;
            rest = comma ? comma + 1 : NULL;
        }
        return 0;
    }
    for (int i = 0; i < (count ? count : __comp_default_count); i++) {
        char name[HAL_NAME_LEN + 1];
        rtapi_snprintf(name, sizeof(name), "gated.%d", i);
        int rc = __comp_make(name, i);
        if (rc != 0) return rc;
    }
    return 0;
}

int rtapi_app_main(void)
{
    int rc;
    if (count && names[0]) {
        rtapi_print_msg(RTAPI_MSG_ERR, "count= and names= are mutually exclusive\n");
        return -EINVAL;
    }
    comp_id = hal_init("gated");
    if (comp_id < 0) return comp_id;
    rc = __comp_make_all();
    if (rc == 0) rc = hal_ready(comp_id);
    if (rc != 0) {
        hal_exit(comp_id);
    }
    return rc;
}

void rtapi_app_exit(void)
{
    hal_exit(comp_id);
}
#undef TRUE
#define TRUE (1)
#undef FALSE
#define FALSE (0)
#undef true
#define true (1)
#undef false
#define false (0)
#undef FUNCTION
#define FUNCTION(name) static void name(struct __comp_state *__comp_inst, long period)
#undef EXTRA_SETUP
#define EXTRA_SETUP() static int extra_setup(struct __comp_state *__comp_inst, char *prefix, long extra_arg)
#undef EXTRA_CLEANUP
#define EXTRA_CLEANUP() static void extra_cleanup(void)
#undef POST_EXPORT
#define POST_EXPORT() static void post_export(struct __comp_state *__comp_inst, char *prefix, long extra_arg)
#undef FOR_ALL_INSTS
#define FOR_ALL_INSTS() for (struct __comp_state *__comp_inst = __comp_first_inst; __comp_inst; __comp_inst = __comp_inst->_next)
#undef fperiod
#define fperiod (period * 1e-9)
#undef personality
#define personality (__comp_inst->_personality)
#undef in
#define in (0 + *__comp_inst->in_p)
#undef in_ptr
#define in_ptr (__comp_inst->in_p)
#undef out
#define out (*__comp_inst->out_p)
#undef out_ptr
#define out_ptr (__comp_inst->out_p)
#undef offset_
#define offset_ (0 + *__comp_inst->offset__p)
#undef offset__ptr
#define offset__ptr (__comp_inst->offset__p)
#undef gain
#define gain (__comp_inst->gain_p)
#undef gain_ptr
#define gain_ptr (&__comp_inst->gain_p)
#undef seen
#define seen(i) (__comp_inst->seen_p[i])
#undef seen_ptr
#define seen_ptr(i) (&__comp_inst->seen_p[i])

static void _(struct __comp_state *__comp_inst, long period) {
#line 10 "gated.comp"
double v = in;
if (personality & 2) v *= gain;
if (personality & 1) v += offset_;
if (personality & 4) seen(1) = (int)v;
out = v;
}
#line 195 "gated.c"

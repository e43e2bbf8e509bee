/* Made by halcompile from new_rows: change that file, not this one. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_string.h"
#include "rtapi_errno.h"
#include "rtapi_math64.h"
#include "hal.h"

static int comp_id;
MODULE_INFO(linuxcnc, "component:new_rows:Arrays of the new types, sized by personality; parameters that are not there can still be used.");
MODULE_INFO(linuxcnc, "pin:in-#:real:4:in::None:None");
MODULE_INFO(linuxcnc, "pin:out-#:real:4:out::None:None");
MODULE_INFO(linuxcnc, "pin:on-##:bool:3:out::1:None");
MODULE_INFO(linuxcnc, "param:scale-#:ui32:2:rw::3:None");
MODULE_INFO(linuxcnc, "param:extra:real:0:rw::9:(personality > 1)");
MODULE_INFO(linuxcnc, "funct:_:1:");
MODULE_INFO(linuxcnc, "license:MIT");
MODULE_LICENSE("MIT");

struct __comp_state {
    struct __comp_state *_next;
    int _personality;
    hal_real_t in_p[4];
    hal_real_t out_p[4];
    hal_bool_t on_p[3];
    hal_uint_t scale_p[2];
    hal_real_t extra_p;
};
static struct __comp_state *__comp_first_inst, *__comp_last_inst;

static void _(struct __comp_state *__comp_inst, long period);

enum { __comp_default_count = 1 };
static int count;
static char *names = "";
RTAPI_MP_INT(count, "How many of new_rows there are.")
RTAPI_MP_STRING(names, "The names of new_rows, with commas between them.")
static int personality[64] = {[0 ... 64 - 1] = 0};
RTAPI_MP_ARRAY_INT(personality, 64, "What each of new_rows is.")

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
    count = (personality + 1);
    if (count > 4) {
        rtapi_print_msg(RTAPI_MSG_ERR, "Pin in-#: Requested size %ld exceeds max size 4\n", count);
        return -ENOSPC;
    }
    for (at = 0; at < count; at++) {
    rc = hal_pin_new_real(comp_id, HAL_IN, &made->in_p[at], 0, "%s.in-%d", prefix, (int)at);
    if (rc != 0) return rc;
    }
    count = (personality + 1);
    if (count > 4) {
        rtapi_print_msg(RTAPI_MSG_ERR, "Pin out-#: Requested size %ld exceeds max size 4\n", count);
        return -ENOSPC;
    }
    for (at = 0; at < count; at++) {
    rc = hal_pin_new_real(comp_id, HAL_OUT, &made->out_p[at], 0, "%s.out-%d", prefix, (int)at);
    if (rc != 0) return rc;
    }
    count = 3;
    for (at = 0; at < count; at++) {
    rc = hal_pin_new_bool(comp_id, HAL_OUT, &made->on_p[at], 1, "%s.on-%02d", prefix, (int)at);
    if (rc != 0) return rc;
    }
    count = 2;
    for (at = 0; at < count; at++) {
    rc = hal_param_new_ui32(comp_id, HAL_RW, &made->scale_p[at], 3, "%s.scale-%d", prefix, (int)at);
    if (rc != 0) return rc;
    }
    if ((personality > 1)) {
    rc = hal_param_new_real(comp_id, HAL_RW, &made->extra_p, 9, "%s.extra", prefix);
    if (rc != 0) return rc;
    } else {
    rc = hal_param_new_fake(comp_id, (hal_refs_u *)&made->extra_p);
    if (rc != 0) return rc;
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
        rtapi_print_msg(RTAPI_MSG_ERR, "new_rows: there are 64 personalities; instance %d takes that of %d\n", index, index % 64);
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
        rtapi_snprintf(name, sizeof(name), "new-rows.%d", i);
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
    comp_id = hal_init("new_rows");
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
#define in(i) (hal_get_real(__comp_inst->in_p[i]))
#undef in_set
#define in_set(i, v) (hal_set_real(__comp_inst->in_p[i], (v)))
#undef in_ptr
#define in_ptr(i) (__comp_inst->in_p[i])
#undef out
#define out(i) (hal_get_real(__comp_inst->out_p[i]))
#undef out_set
#define out_set(i, v) (hal_set_real(__comp_inst->out_p[i], (v)))
#undef out_ptr
#define out_ptr(i) (__comp_inst->out_p[i])
#undef on
#define on(i) (hal_get_bool(__comp_inst->on_p[i]))
#undef on_set
#define on_set(i, v) (hal_set_bool(__comp_inst->on_p[i], (v)))
#undef on_ptr
#define on_ptr(i) (__comp_inst->on_p[i])
#undef scale
#define scale(i) (hal_get_ui32(__comp_inst->scale_p[i]))
#undef scale_set
#define scale_set(i, v) (hal_set_ui32(__comp_inst->scale_p[i], (v)))
#undef scale_ptr
#define scale_ptr(i) (__comp_inst->scale_p[i])
#undef extra
#define extra (hal_get_real(__comp_inst->extra_p))
#undef extra_set
#define extra_set(v) (hal_set_real(__comp_inst->extra_p, (v)))
#undef extra_ptr
#define extra_ptr (__comp_inst->extra_p)

static void _(struct __comp_state *__comp_inst, long period) {
#line 10 "new_rows.comp"
int i;
for (i = 0; i < personality + 1; i++) out_set(i, in(i) * scale(0));
on_set(2, in(0) > 1);
extra_set(extra + 1);
}
#line 217 "new_rows.c"

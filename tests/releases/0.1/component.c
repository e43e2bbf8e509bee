/* A component in C, compiled with the headers of release 0.1 in the folder `include`. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"

MODULE_LICENSE("GPL");
static char *text = "none";
RTAPI_MP_STRING(text, "A text");
static int id;
typedef struct { hal_s32_t *count; hal_bit_t *enable; hal_u32_t step; } data_t;
static data_t *data;

static void count(void *arg, long period) {
    (void)arg; (void)period;
    if (*data->enable) *data->count += data->step;
}

int rtapi_app_main(void) {
    id = hal_init("component");
    if (id < 0) return id;
    data = hal_malloc(sizeof *data);
    if (!data || hal_pin_s32_newf(HAL_OUT, &data->count, id, "component.%d.count", 0) != 0
        || hal_pin_bit_newf(HAL_IN, &data->enable, id, "component.%d.enable", 0) != 0
        || hal_param_u32_newf(HAL_RW, &data->step, id, "component.%d.step", 0) != 0
        || hal_export_funct("component.count", count, 0, 0, 0, id) != 0) {
        hal_exit(id);
        return -1;
    }
    data->step = text[0] == 't' ? 3 : 1;
    hal_ready(id);
    return 0;
}

void rtapi_app_exit(void) { hal_exit(id); }

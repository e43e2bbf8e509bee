/* What a component in C sees of a bit: its byte as a number. Components that compare a bit with 1
 * or take the exclusive or of two rely on 0 and 1. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"

MODULE_LICENSE("GPL");

static struct raw {
    hal_bit_t *in;
    hal_u32_t *byte;
} *raw;

static int component;

static void look(void *arg, long period)
{
    (void)arg;
    (void)period;
    *raw->byte = *(volatile unsigned char *)raw->in;
}

int rtapi_app_main(void)
{
    component = hal_init("rawbyte");
    if (component < 0)
        return component;
    raw = hal_malloc(sizeof *raw);
    if (!raw || hal_pin_bit_new("rawbyte.in", HAL_IN, &raw->in, component) ||
        hal_pin_u32_new("rawbyte.byte", HAL_OUT, &raw->byte, component) ||
        hal_export_funct("rawbyte", look, NULL, 0, 0, component))
        return -EINVAL;
    return hal_ready(component);
}

void rtapi_app_exit(void)
{
    hal_exit(component);
}

/* Homing of a user that lacks most functions. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include "homing.h"

MODULE_LICENSE("GPL");

int rtapi_app_main(void)
{
    int component = hal_init("half");
    return component < 0 ? component : hal_ready(component);
}

void rtapi_app_exit(void)
{
}

bool do_homing(void)
{
    return false;
}

EXPORT_SYMBOL(do_homing);

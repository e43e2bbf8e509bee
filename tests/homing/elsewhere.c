/* Homing of a user with headers of its own: nobody knows what it takes a joint for. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_bool.h"
#include "hal.h"

MODULE_LICENSE("GPL");

int rtapi_app_main(void)
{
    int component = hal_init("elsewhere");
    return component < 0 ? component : hal_ready(component);
}

void rtapi_app_exit(void)
{
}

#define FUNCTION_OF(type, name, args) \
    type name args                    \
    {                                 \
        return (type)0;               \
    }                                 \
    EXPORT_SYMBOL(name);
#define ACTION(name, args) \
    void name args         \
    {                      \
    }                      \
    EXPORT_SYMBOL(name);

FUNCTION_OF(int, homing_init, (int id, double period, int n, int n_extra, void *joints))
FUNCTION_OF(bool, do_homing, (void))
FUNCTION_OF(bool, get_allhomed, (void))
FUNCTION_OF(bool, get_homing_is_active, (void))
FUNCTION_OF(int, get_home_sequence, (int j))
FUNCTION_OF(bool, get_homing, (int j))
FUNCTION_OF(bool, get_homed, (int j))
FUNCTION_OF(bool, get_index_enable, (int j))
FUNCTION_OF(bool, get_home_needs_unlock_first, (int j))
FUNCTION_OF(bool, get_home_is_idle, (int j))
FUNCTION_OF(bool, get_home_is_synchronized, (int j))
FUNCTION_OF(bool, get_homing_at_index_search_wait, (int j))
ACTION(homeMotFunctions, (void (*set)(int, int), int (*get)(int)))
ACTION(read_homing_in_pins, (int n))
ACTION(write_homing_out_pins, (int n))
ACTION(do_home_joint, (int j))
ACTION(do_cancel_homing, (int j))
ACTION(set_unhomed, (int j, int state))
ACTION(set_joint_homing_params, (int j, double a, double b, double c, double d, double e, int f, int g, bool h))
ACTION(update_joint_homing_params, (int j, double a, double b, int c))

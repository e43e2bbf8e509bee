/* Another name of rtapi_parport.h. */
#ifndef HAL_PARPORT_H
#define HAL_PARPORT_H
#include "rtapi_parport.h"
typedef rtapi_parport_t hal_parport_t;
#define hal_parport_get(comp, port, base, base_hi, modes) \
    rtapi_parport_get(hal_comp_name(comp), (port), (base), (base_hi), (modes))
#define hal_parport_release(port) rtapi_parport_release(port)
#endif

/* Reserves a parallel port. Under the virtual clock and with --simulate every port is there. */
#ifndef RTAPI_PARPORT_H
#define RTAPI_PARPORT_H
#include "rtapi_io.h"

typedef struct rtapi_parport_t {
    unsigned short base;
    unsigned short base_hi;
    int fd;
} rtapi_parport_t;

#define PARPORT_MODE_PCSPP (1 << 0)
#define PARPORT_MODE_TRISTATE (1 << 1)
#define PARPORT_MODE_EPP (1 << 2)
#define PARPORT_MODE_ECP (1 << 3)
#define PARPORT_MODE_COMPAT (1 << 4)
#define PARPORT_MODE_DMA (1 << 5)
#define PARPORT_MODE_SAFEININT (1 << 6)

#ifdef __cplusplus
extern "C" {
#endif
/* base_hi 0: base + 0x400. Zero, or a negative error number. */
extern int rtapi_parport_get(const char *module, rtapi_parport_t *port, unsigned short base,
                             unsigned short base_hi, unsigned int modes);
extern void rtapi_parport_release(rtapi_parport_t *port);
#ifdef __cplusplus
}
#endif
#endif

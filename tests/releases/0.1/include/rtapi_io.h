/* Ports of the processor. They go through Ferrule: under the virtual clock and with --simulate
 * they reach a register file whose bits are pins. */
#ifndef RTAPI_IO_H
#define RTAPI_IO_H
#include "rtapi_stdint.h"

#ifdef __cplusplus
extern "C" {
#endif
extern unsigned char rtapi_inb(unsigned short port);
extern unsigned short rtapi_inw(unsigned short port);
extern unsigned int rtapi_inl(unsigned short port);
extern void rtapi_outb(unsigned char value, unsigned short port);
extern void rtapi_outw(unsigned short value, unsigned short port);
extern void rtapi_outl(unsigned int value, unsigned short port);
/* As the system's ioperm and iopl: zero, or -1 with errno. */
extern int rtapi_ioperm(unsigned long from, unsigned long count, int on);
extern int rtapi_iopl(int level);
#ifdef __cplusplus
}
#endif
/* Reserves ports: not NULL if this process may use them. */
#define rtapi_request_region(base, size, name) \
    ((void)(name), rtapi_ioperm((base), (size), 1) == 0 ? (void *)-1 : (void *)0)
#define rtapi_release_region(base, size) ((void)rtapi_ioperm((base), (size), 0))
#endif

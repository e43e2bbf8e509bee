/* The system's port calls for components that name them: the same, through Ferrule. */
#ifndef FERRULE_SYS_IO_H
#define FERRULE_SYS_IO_H
#include "../rtapi_io.h"
#define inb(port) rtapi_inb(port)
#define inw(port) rtapi_inw(port)
#define inl(port) rtapi_inl(port)
#define outb(value, port) rtapi_outb((value), (port))
#define outw(value, port) rtapi_outw((value), (port))
#define outl(value, port) rtapi_outl((value), (port))
#define inb_p(port) rtapi_inb(port)
#define outb_p(value, port) rtapi_outb((value), (port))
#define ioperm(from, count, on) rtapi_ioperm((from), (count), (on))
#define iopl(level) rtapi_iopl(level)
#endif

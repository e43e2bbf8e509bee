/* The system's port calls for components that name them: the same, through Ferrule. They are functions, so that a
 * component may also give their names to others: #define rtapi_inl inl */
#ifndef FERRULE_SYS_IO_H
#define FERRULE_SYS_IO_H
#include "../rtapi_io.h"
#ifdef __cplusplus
extern "C" {
#endif
extern unsigned char inb(unsigned short port) __asm__("rtapi_inb");
extern unsigned short inw(unsigned short port) __asm__("rtapi_inw");
extern unsigned int inl(unsigned short port) __asm__("rtapi_inl");
extern void outb(unsigned char value, unsigned short port) __asm__("rtapi_outb");
extern void outw(unsigned short value, unsigned short port) __asm__("rtapi_outw");
extern void outl(unsigned int value, unsigned short port) __asm__("rtapi_outl");
extern unsigned char inb_p(unsigned short port) __asm__("rtapi_inb");
extern void outb_p(unsigned char value, unsigned short port) __asm__("rtapi_outb");
extern int ioperm(unsigned long from, unsigned long count, int on) __asm__("rtapi_ioperm");
extern int iopl(int level) __asm__("rtapi_iopl");
#ifdef __cplusplus
}
#endif
#endif

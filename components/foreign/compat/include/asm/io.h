/* Another name of sys/io.h, for components that were written for the kernel. */
#ifndef FERRULE_ASM_IO_H
#define FERRULE_ASM_IO_H
#include "../linux/version.h"
#include "../sys/io.h"
#endif

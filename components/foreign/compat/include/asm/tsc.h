/* Clocks in a millisecond: one is a nanosecond, as with rtapi_get_clocks(). */
#ifndef FERRULE_ASM_TSC_H
#define FERRULE_ASM_TSC_H
extern unsigned int cpu_khz;
#endif

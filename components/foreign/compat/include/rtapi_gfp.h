/* Kinds of memory; there is one. */
#ifndef RTAPI_GFP_H
#define RTAPI_GFP_H
typedef int rtapi_gfp_t;
#define RTAPI_GFP_KERNEL 0
#define RTAPI_GFP_ATOMIC 0
#endif

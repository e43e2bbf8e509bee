/* The order of bytes. */
#ifndef RTAPI_BYTEORDER_H
#define RTAPI_BYTEORDER_H
#include <endian.h>
#if __BYTE_ORDER == __BIG_ENDIAN
#define RTAPI_BIG_ENDIAN 1
#define RTAPI_FLOAT_BIG_ENDIAN 1
#else
#define RTAPI_LITTLE_ENDIAN 1
#define RTAPI_FLOAT_LITTLE_ENDIAN 1
#endif
#define RTAPI_BYTE_ORDER __BYTE_ORDER
#endif

/* Integers of a known width, and the wide types of the new pin interface. */
#ifndef RTAPI_STDINT_H
#define RTAPI_STDINT_H
#include <inttypes.h>
#include <stdint.h>
/* uint, ulong and ushort. */
#include <sys/types.h>
#include "rtapi_bool.h"

typedef int8_t rtapi_s8;
typedef int16_t rtapi_s16;
typedef int32_t rtapi_s32;
typedef int64_t rtapi_s64;
typedef intptr_t rtapi_intptr_t;
typedef uint8_t rtapi_u8;
typedef uint16_t rtapi_u16;
typedef uint32_t rtapi_u32;
typedef uint64_t rtapi_u64;
typedef uintptr_t rtapi_uintptr_t;

typedef int64_t rtapi_sint;
typedef uint64_t rtapi_uint;
typedef double rtapi_real;
typedef double real_t;
/* An integer as wide as a real_t. */
typedef uint64_t ireal_t;

#define RTAPI_INT8_MAX INT8_MAX
#define RTAPI_INT8_MIN INT8_MIN
#define RTAPI_UINT8_MAX UINT8_MAX
#define RTAPI_INT16_MAX INT16_MAX
#define RTAPI_INT16_MIN INT16_MIN
#define RTAPI_UINT16_MAX UINT16_MAX
#define RTAPI_INT32_MAX INT32_MAX
#define RTAPI_INT32_MIN INT32_MIN
#define RTAPI_UINT32_MAX UINT32_MAX
#define RTAPI_INT64_MAX INT64_MAX
#define RTAPI_INT64_MIN INT64_MIN
#define RTAPI_UINT64_MAX UINT64_MAX
#endif

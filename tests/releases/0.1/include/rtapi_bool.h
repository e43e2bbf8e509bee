/* Truth values, in C and in C++. */
#ifndef RTAPI_BOOL_H
#define RTAPI_BOOL_H
#ifndef __cplusplus
#include <stdbool.h>
#endif
#ifndef TRUE
#define TRUE 1
#endif
#ifndef FALSE
#define FALSE 0
#endif
typedef bool rtapi_bool;
#endif

/* Kinds of letters: those of the system. */
#ifndef RTAPI_CTYPE_H
#define RTAPI_CTYPE_H
#include <ctype.h>
#endif

/* Texts: those of the system, and copies that cannot overrun. */
#ifndef RTAPI_STRING_H
#define RTAPI_STRING_H
#include <string.h>
#include <strings.h>
#include "rtapi_gfp.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Copies at most size - 1 bytes and ends them; the length of the source comes back. */
static inline size_t rtapi_strlcpy(char *to, const char *from, size_t size)
{
    size_t length = strlen(from);
    if (size > 0) {
        size_t part = length < size ? length : size - 1;
        memcpy(to, from, part);
        to[part] = '\0';
    }
    return length;
}

/* Appends, so that all fits into size bytes; the length that it would have comes back. */
static inline size_t rtapi_strlcat(char *to, const char *from, size_t size)
{
    size_t had = strnlen(to, size);
    return had + rtapi_strlcpy(to + had, from, size - had);
}

/* As above into an array whose size the compiler knows. */
#define rtapi_strxcpy(to, from) rtapi_strlcpy((to), (from), sizeof(to))
#define rtapi_strxcat(to, from) rtapi_strlcat((to), (from), sizeof(to))

static inline char *rtapi_kstrdup(const char *text, rtapi_gfp_t flags)
{
    (void)flags;
    return strdup(text);
}

/* Splits a text at blanks; the list ends with a null pointer and is given back with the second. */
extern char **rtapi_argv_split(rtapi_gfp_t flags, const char *text, int *count);
extern void rtapi_argv_free(char **list);

#ifdef __cplusplus
}
#endif
#endif

/* A client of a running instance of Ferrule, for C and for languages that call C.
 *
 * Link with libferrule_client, which lies beside halrun:
 *     cc -I INCLUDE program.c -L BIN -lferrule_client -Wl,-rpath,BIN
 *
 * A handle belongs to one thread at a time. Texts are UTF-8. Names and values are those of halcmd's getp and setp.
 * Programs with pins of their own use hal.h with the same library.
 */
#ifndef FERRULE_H
#define FERRULE_H

#ifdef __cplusplus
extern "C" {
#endif

/* A connection. */
typedef struct ferrule ferrule;

/* Connects to the instance of this name; NULL is the one in HAL_INSTANCE, or "default". Returns NULL if it cannot, and
 * then *why, if why is not NULL, is the reason, which ferrule_free frees. */
ferrule *ferrule_connect(const char *instance, char **why);

/* Ends the connection. NULL does nothing. */
void ferrule_close(ferrule *f);

/* Sends a request and waits for its answer, both JSON as on the socket: {"get":{"name":"and2.0.out"}} or "status".
 * Returns the answer, {"ok":...} or {"error":...}, which ferrule_free frees; NULL if the request has no meaning or the
 * connection is lost. */
char *ferrule_request(ferrule *f, const char *request);

/* Reads a pin, parameter or signal as a number; a bit is 0 or 1. Returns 0, or a negative error number. */
int ferrule_get(ferrule *f, const char *name, double *value);

/* Sets a pin, parameter or signal from a text such as "1.5" or "TRUE". Returns 0, or a negative error number. */
int ferrule_set(ferrule *f, const char *name, const char *value);

/* Returns the reason why the last call failed. It is valid until the next call with the same handle. */
const char *ferrule_error(const ferrule *f);

/* Frees a text of this library. NULL does nothing. */
void ferrule_free(char *text);

#ifdef __cplusplus
}
#endif
#endif

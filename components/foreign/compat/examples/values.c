/* Reads and sets values of a running instance:
 *     halrun -b machine.hal
 *     cc -I include examples/values.c -L BIN -lferrule_client -Wl,-rpath,BIN -o values && ./values sum
 */
#include "ferrule.h"
#include <stdio.h>

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "sum";
    char *why = NULL;
    ferrule *f = ferrule_connect(NULL, &why);
    if (!f) {
        fprintf(stderr, "%s\n", why);
        ferrule_free(why);
        return 1;
    }
    double value;
    if (ferrule_get(f, name, &value) == 0)
        printf("%s = %g\n", name, value);
    if (ferrule_set(f, name, "2.5") == 0 && ferrule_get(f, name, &value) == 0)
        printf("%s = %g\n", name, value);
    if (ferrule_get(f, "no-such-name", &value) < 0)
        printf("%s\n", ferrule_error(f));
    char *answer = ferrule_request(f, "{\"get-signal\":{\"name\":\"sum\"}}");
    printf("%s\n", answer ? answer : ferrule_error(f));
    ferrule_free(answer);
    if (!ferrule_request(f, "{\"dance\":{}}"))
        printf("refused: no such request\n");
    ferrule_close(f);
    return 0;
}

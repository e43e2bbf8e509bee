/* Asks a module of LinuxCNC's kinematics: what comes on lines is answered on lines.
 *
 *   pins                        NAME TYPE DIRECTION VALUE of each, then "."
 *   set NAME VALUE              sets a pin or parameter that is a float
 *   switch N                    another type
 *   forward 16 joints, 9 guess  result, pose, flags for the other way
 *   inverse 9 pose, 16 guess, flags   result, joints
 */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct { char name[64], type; int direction; void *cell; } items[512];
static int count;

static void *item(char type, int direction, void *given, const char *format, va_list rest)
{
    vsnprintf(items[count].name, sizeof items[count].name, format, rest);
    items[count].type = type;
    items[count].direction = direction;
    items[count].cell = given ? given : calloc(1, 8);
    return items[count++].cell;
}

static void *plain(char type, int direction, const char *format, ...)
{
    va_list rest;
    va_start(rest, format);
    void *cell = item(type, direction, 0, format, rest);
    va_end(rest);
    return cell;
}

#define KIND(name, type)                                                                          \
    int hal_pin_##name##_newf(int d, void **p, int id, const char *format, ...)                   \
    {                                                                                             \
        va_list rest;                                                                             \
        va_start(rest, format);                                                                   \
        *p = item(type, d, 0, format, rest);                                                      \
        va_end(rest);                                                                             \
        return 0;                                                                                 \
    }                                                                                             \
    int hal_param_##name##_newf(int d, void *p, int id, const char *format, ...)                  \
    {                                                                                             \
        va_list rest;                                                                             \
        va_start(rest, format);                                                                   \
        item(type, d, p, format, rest);                                                           \
        va_end(rest);                                                                             \
        return 0;                                                                                 \
    }                                                                                             \
    int hal_pin_##name##_new(const char *n, int d, void **p, int id)                              \
    {                                                                                             \
        *p = plain(type, d, "%s", n);                                                             \
        return 0;                                                                                 \
    }
KIND(float, 'f')
KIND(bit, 'b')
KIND(s32, 's')
KIND(u32, 'u')

int hal_init(const char *name) { return 1; }
int hal_ready(int id) { return 0; }
int hal_set_unready(int id) { return 0; }
int hal_exit(int id) { return 0; }
void *hal_malloc(long size) { return calloc(1, size); }
int hal_export_funct(const char *n, void *f, void *a, int fp, int r, int id) { return 0; }
void rtapi_print(const char *format, ...) {}
void rtapi_print_msg(int level, const char *format, ...) {}
int rtapi_snprintf(char *to, unsigned long size, const char *format, ...)
{
    va_list rest;
    va_start(rest, format);
    int n = vsnprintf(to, size, format, rest);
    va_end(rest);
    return n;
}

static double value(int i)
{
    switch (items[i].type) {
    case 'f': return *(double *)items[i].cell;
    case 'b': return *(char *)items[i].cell;
    case 's': return *(int *)items[i].cell;
    default: return *(unsigned *)items[i].cell;
    }
}

static void numbers(double *to, int n)
{
    for (int i = 0; i < n; i++) to[i] = strtod(strtok(0, " \n"), 0);
}

static void tell(int result, const double *from, int n, unsigned long flags)
{
    printf("%d", result);
    for (int i = 0; i < n; i++) printf(" %.17g", from[i]);
    printf(" %lu\n", flags);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    void *module = dlopen(argv[1], RTLD_NOW | RTLD_GLOBAL);
    if (!module) return fprintf(stderr, "%s\n", dlerror()), 1;
    int (*begin)(void) = dlsym(module, "rtapi_app_main");
    int (*type)(void) = dlsym(module, "kinematicsType");
    int (*change)(int) = dlsym(module, "kinematicsSwitch");
    int (*forward)(const double *, double *, unsigned long *, unsigned long *) =
        dlsym(module, "kinematicsForward");
    int (*inverse)(const double *, double *, unsigned long *, unsigned long *) =
        dlsym(module, "kinematicsInverse");
    if (begin()) return 2;
    type();
    static char line[4096];
    while (fgets(line, sizeof line, stdin)) {
        double joints[16], pose[9], more[1];
        unsigned long ahead = 0, back = 0;
        char *word = strtok(line, " \n");
        if (!word) continue;
        if (!strcmp(word, "pins")) {
            for (int i = 0; i < count; i++)
                printf("%s %c %d %.17g\n", items[i].name, items[i].type, items[i].direction, value(i));
            puts(".");
            fflush(stdout);
        } else if (!strcmp(word, "set")) {
            char *name = strtok(0, " \n");
            numbers(more, 1);
            for (int i = 0; i < count; i++)
                if (!strcmp(items[i].name, name)) *(double *)items[i].cell = more[0];
        } else if (!strcmp(word, "switch")) {
            numbers(more, 1);
            change((int)more[0]);
        } else if (!strcmp(word, "forward")) {
            numbers(joints, 16);
            numbers(pose, 9);
            int result = forward(joints, pose, &ahead, &back);
            tell(result, pose, 9, back);
        } else if (!strcmp(word, "inverse")) {
            numbers(pose, 9);
            numbers(joints, 16);
            numbers(more, 1);
            back = (unsigned long)more[0];
            int result = inverse(pose, joints, &back, &ahead);
            tell(result, joints, 16, back);
        }
    }
    return 0;
}

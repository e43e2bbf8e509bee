// Stands in for a parallel port that is not there: byte accesses to I/O ports fault in a program
// without rights to them, and are carried out here on a register file and noted in PORTS_LOG.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <ucontext.h>
#include <unistd.h>

static int note = -1;
static unsigned char file[65536];

static void carry_out(int number, siginfo_t *info, void *context) {
    greg_t *regs = ((ucontext_t *)context)->uc_mcontext.gregs;
    unsigned char op = *(unsigned char *)regs[REG_RIP];
    unsigned port = regs[REG_RDX] & 0xffff;
    (void)number, (void)info;
    if (op == 0xee) file[port] = regs[REG_RAX] & 0xff;                            // out dx, al
    else if (op == 0xec) regs[REG_RAX] = (regs[REG_RAX] & ~0xffLL) | file[port];  // in al, dx
    else _exit(99);
    regs[REG_RIP] += 1;
    dprintf(note, "%s %03x=%02x\n", op == 0xee ? "w" : "r", port, file[port]);
}

// The program may not take the fault back.
int sigaction(int number, const struct sigaction *act, struct sigaction *old) {
    static int (*real)(int, const struct sigaction *, struct sigaction *);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "sigaction");
    if (number == SIGSEGV && act && act->sa_sigaction != carry_out) return 0;
    return real(number, act, old);
}

__attribute__((constructor)) static void begin(void) {
    const char *path = getenv("PORTS_LOG");
    struct sigaction act = {.sa_sigaction = carry_out, .sa_flags = SA_SIGINFO};
    if (path) note = open(path, O_WRONLY | O_CREAT | O_APPEND, 0644);
    if (note >= 0) sigaction(SIGSEGV, &act, NULL);
}

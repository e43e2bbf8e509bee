/* The driver of viagpio_old.c without its mistakes.
 *
 * It looks which chip it has before it writes anything, claims its ports, reaches byte registers
 * by bytes, keeps what is beside its lines, and writes each register once. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include <sys/io.h>

MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("Digital lines of a VIA VX900");

#define CONFIG_ADDRESS 0xCF8
#define CONFIG_VALUE 0xCFC
/* Bus 0, device 17, function 0, and what it must be. */
#define CHIP 0x80008800u
#define IDENTITY 0x84101106u
/* The block of registers is aligned to its size; the lower bits of its base are flags. */
#define BLOCK 0xFF80u

enum { INPUTS = 4, OUTPUTS = 4, REGISTERS = 3 };

/* Which register, of those that are read or of those that are written, and its bit. */
static const struct { int reg; unsigned char mask; } inputs[INPUTS] = {
    { 0, 0x10 }, { 0, 0x20 }, { 1, 0x01 }, { 1, 0x02 },
}, outputs[OUTPUTS] = {
    { 2, 0x04 }, { 0, 0x10 }, { 1, 0x10 }, { 1, 0x80 },
};

enum { FIRST_INPUT = 0x48, FIRST_OUTPUT = 0x4D };

static struct board {
    unsigned short base;
    unsigned char rest[REGISTERS];
    hal_bit_t *in[INPUTS], *in_not[INPUTS];
    hal_bit_t *out[OUTPUTS];
    hal_bit_t invert[OUTPUTS];
} *board;

static int component;

static unsigned int configuration(unsigned int reg)
{
    outl(CHIP | reg, CONFIG_ADDRESS);
    return inl(CONFIG_VALUE);
}

static void configure(unsigned int reg, unsigned int clear, unsigned int set)
{
    unsigned int value = configuration(reg);
    unsigned int wanted = (value & ~clear) | set;
    if (wanted != value)
        outl(wanted, CONFIG_VALUE);
}

static void read_lines(void *arg, long period)
{
    unsigned char value[2];
    (void)arg;
    (void)period;
    for (int r = 0; r < 2; r++)
        value[r] = inb(board->base + FIRST_INPUT + r);
    for (int n = 0; n < INPUTS; n++) {
        int level = (value[inputs[n].reg] & inputs[n].mask) != 0;
        *board->in[n] = level;
        *board->in_not[n] = !level;
    }
}

static void write_lines(void *arg, long period)
{
    unsigned char value[REGISTERS];
    (void)arg;
    (void)period;
    for (int r = 0; r < REGISTERS; r++)
        value[r] = board->rest[r];
    for (int n = 0; n < OUTPUTS; n++)
        if (*board->out[n] != board->invert[n])
            value[outputs[n].reg] |= outputs[n].mask;
    for (int r = 0; r < REGISTERS; r++)
        outb(value[r], board->base + FIRST_OUTPUT + r);
}

static int bring_up(void)
{
    unsigned int identity, base;
    if (ioperm(CONFIG_ADDRESS, 8, 1)) {
        rtapi_print_msg(RTAPI_MSG_ERR, "no right to use I/O ports: run as root\n");
        return -EPERM;
    }
    identity = configuration(0x00);
    if (identity != IDENTITY) {
        rtapi_print_msg(RTAPI_MSG_ERR, "device 00:11.0 is %04x:%04x, not the VX900; nothing was "
                        "written to it\n", identity & 0xFFFF, identity >> 16);
        return -ENODEV;
    }
    base = configuration(0x88) & BLOCK;
    if (!base) {
        rtapi_print_msg(RTAPI_MSG_ERR, "the firmware gave the registers no address\n");
        return -ENODEV;
    }
    if (ioperm(base + FIRST_INPUT, 2, 1) || ioperm(base + FIRST_OUTPUT, REGISTERS, 1))
        return -EPERM;
    board->base = base;
    for (int r = 0; r < REGISTERS; r++)
        board->rest[r] = inb(base + FIRST_OUTPUT + r);
    for (int n = 0; n < OUTPUTS; n++)
        board->rest[outputs[n].reg] &= ~outputs[n].mask;
    configure(0x98, 0, 0x01000000);
    configure(0x94, 0, 0x00000C00);
    configure(0x80, 0x00000040, 0);
    return 0;
}

static int export(void)
{
    for (int n = 0; n < INPUTS; n++) {
        if (hal_pin_bit_newf(HAL_OUT, &board->in[n], component, "viagpio.pin-%02d-in", n + 1))
            return -EINVAL;
        if (hal_pin_bit_newf(HAL_OUT, &board->in_not[n], component, "viagpio.pin-%02d-in-not",
                             n + 1))
            return -EINVAL;
    }
    for (int n = 0; n < OUTPUTS; n++) {
        int number = INPUTS + n + 1;
        if (hal_pin_bit_newf(HAL_IN, &board->out[n], component, "viagpio.pin-%02d-out", number))
            return -EINVAL;
        if (hal_param_bit_newf(HAL_RW, &board->invert[n], component,
                               "viagpio.pin-%02d-out-invert", number))
            return -EINVAL;
    }
    if (hal_export_funct("viagpio.read", read_lines, NULL, 0, 0, component))
        return -EINVAL;
    return hal_export_funct("viagpio.write", write_lines, NULL, 0, 0, component);
}

int rtapi_app_main(void)
{
    int code;
    component = hal_init("viagpio_mended");
    if (component < 0)
        return component;
    board = hal_malloc(sizeof *board);
    code = board ? bring_up() : -ENOMEM;
    if (!code)
        code = export();
    if (code) {
        hal_exit(component);
        return code;
    }
    return hal_ready(component);
}

void rtapi_app_exit(void)
{
    hal_exit(component);
}

/* A driver of the old style for the four inputs and four outputs of a board with a VIA VX900, with
 * the mistakes that such drivers have: the test says which, and what the recorder shows of each.
 * viagpio_mended.c is the same driver without them.
 *
 * It takes the chip for granted, changes its PCI configuration with wrong masks, reaches byte
 * registers by double words, and changes two lines of one register from two copies of it. */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include <sys/io.h>

MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("Digital lines of a VIA VX900, the old way");

static int bytes = 0;
RTAPI_MP_INT(bytes, "1: registers are reached by bytes, as they should be");

#define CONFIG_ADDRESS 0xCF8
#define CONFIG_VALUE 0xCFC
/* Bus 0, device 17, function 0. */
#define CHIP 0x80008800u

enum { INPUTS = 4, OUTPUTS = 4, LINES = INPUTS + OUTPUTS };

/* Register, from the base, and bit: four inputs, four outputs. */
static const struct { unsigned short offset; unsigned char mask; } lines[LINES] = {
    { 0x48, 0x10 }, { 0x48, 0x20 }, { 0x49, 0x01 }, { 0x49, 0x02 },
    { 0x4F, 0x04 }, { 0x4D, 0x10 }, { 0x4E, 0x10 }, { 0x4E, 0x80 },
};

static struct board {
    unsigned short address[LINES];
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
    outl(CHIP | reg, CONFIG_ADDRESS);
    outl((value & ~clear) | set, CONFIG_VALUE);
}

/* A double word, where the register is a byte. */
static unsigned char get(unsigned short address)
{
    return bytes ? inb(address) : (unsigned char)inl(address);
}

static void put(unsigned char value, unsigned short address)
{
    if (bytes)
        outb(value, address);
    else
        outl(value, address);
}

static void read_lines(void *arg, long period)
{
    (void)arg;
    (void)period;
    for (int n = 0; n < INPUTS; n++) {
        unsigned char level = get(board->address[n]) & lines[n].mask;
        /* The bit as it is in the register: 0x10, 0x20, 0x01 or 0x02. */
        *(volatile unsigned char *)board->in[n] = level;
        *(volatile unsigned char *)board->in_not[n] = !level;
    }
}

static void write_lines(void *arg, long period)
{
    unsigned char value[OUTPUTS];
    (void)arg;
    (void)period;
    for (int n = 0; n < OUTPUTS; n++)
        value[n] = get(board->address[INPUTS + n]);
    for (int n = 0; n < OUTPUTS; n++) {
        unsigned char mask = lines[INPUTS + n].mask;
        if (*board->out[n] != board->invert[n])
            value[n] |= mask;
        else
            value[n] &= ~mask;
    }
    for (int n = 0; n < OUTPUTS; n++)
        put(value[n], board->address[INPUTS + n]);
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
    unsigned short base = configuration(0x88) & 0xFFFE;
    configure(0x98, 0, 0x01000000);
    configure(0x94, 0, 0x0000000C);
    configure(0x80, 0, 0);
    component = hal_init("viagpio_old");
    if (component < 0)
        return component;
    board = hal_malloc(sizeof *board);
    if (!board)
        return -ENOMEM;
    for (int n = 0; n < LINES; n++)
        board->address[n] = base + lines[n].offset;
    if (export()) {
        rtapi_print_msg(RTAPI_MSG_ERR, "OTHER-PRODUCT: export failed\n");
        hal_exit(component);
        return -1;
    }
    return hal_ready(component);
}

void rtapi_app_exit(void)
{
    hal_exit(component);
}

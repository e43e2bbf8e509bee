/* Serial ports of a Mesa card, as the component hostmot2 offers them: load it before. Each function returns zero or a
 * count, or a negative error number. */
#ifndef HOSTMOT2_SERIAL_H
#define HOSTMOT2_SERIAL_H
#include "rtapi.h"

RTAPI_BEGIN_DECLS
/* Plain ports. A read returns the number of bytes; 16 at most are moved by one call. */
extern int hm2_uart_setup(char *name, int bitrate, rtapi_s32 tx_mode, rtapi_s32 rx_mode);
extern int hm2_uart_send(char *name, unsigned char data[], int count);
extern int hm2_uart_read(char *name, unsigned char data[]);

/* Ports that move whole frames. */
extern int hm2_pktuart_setup(char *name, int bitrate, rtapi_s32 tx_mode, rtapi_s32 rx_mode,
                             int clear_tx, int clear_rx);
extern int hm2_pktuart_send(char *name, unsigned char data[], rtapi_u8 *frames,
                            rtapi_u16 frame_sizes[]);
extern int hm2_pktuart_read(char *name, unsigned char data[], rtapi_u8 *frames,
                            rtapi_u16 *max_frame, rtapi_u16 frame_sizes[]);

/* Buffered SPI. Frames of the process are written and read with those of the card. */
extern int hm2_bspi_setup_chan(char *name, int chan, int cs, int bits, double mhz, int delay,
                               int cpol, int cpha, int noclear, int noecho, int samplelate);
/* Older sources call it without the last argument. */
#define hm2_bspi_setup_chan(...) \
    FERRULE_BSPI(__VA_ARGS__, FERRULE_BSPI_11, FERRULE_BSPI_10, 0)(__VA_ARGS__)
#define FERRULE_BSPI(a, b, c, d, e, f, g, h, i, j, k, pick, ...) pick
#define FERRULE_BSPI_11(...) (hm2_bspi_setup_chan)(__VA_ARGS__)
#define FERRULE_BSPI_10(...) (hm2_bspi_setup_chan)(__VA_ARGS__, 0)
extern int hm2_bspi_write_chan(char *name, int chan, rtapi_u32 value);
extern int hm2_bspi_set_read_function(char *name, int (*code)(void *data), void *data);
extern int hm2_bspi_set_write_function(char *name, int (*code)(void *data), void *data);
extern int hm2_bspi_clear_fifo(char *name);
extern int hm2_tram_add_bspi_frame(char *name, int chan, rtapi_u32 **to_write, rtapi_u32 **read);
extern int hm2_allocate_bspi_tram(char *name);
RTAPI_END_DECLS
#endif

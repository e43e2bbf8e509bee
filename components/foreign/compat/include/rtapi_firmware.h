/* Files in /lib/firmware, read whole. */
#ifndef RTAPI_FIRMWARE_H
#define RTAPI_FIRMWARE_H
#include <stddef.h>
#include "rtapi_device.h"
#include "rtapi_stdint.h"

struct rtapi_firmware {
    size_t size;
    const rtapi_u8 *data;
    void *priv;
};

#ifdef __cplusplus
extern "C" {
#endif
/* Zero, or a negative error number. */
extern int rtapi_request_firmware(const struct rtapi_firmware **firmware, const char *name,
                                  struct rtapi_device *device);
extern void rtapi_release_firmware(const struct rtapi_firmware *firmware);
#ifdef __cplusplus
}
#endif
#endif

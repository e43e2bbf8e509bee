/* A device, as drivers name it. */
#ifndef RTAPI_DEVICE_H
#define RTAPI_DEVICE_H
struct rtapi_device {
    const char *name;
    void *driver_data;
};
static inline const char *rtapi_dev_name(const struct rtapi_device *device)
{
    return device->name;
}
#endif

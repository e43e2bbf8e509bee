/* PCI devices, as drivers name them. None is offered: a driver compiles, and finds no device when it is loaded. */
#ifndef RTAPI_PCI_H
#define RTAPI_PCI_H
#include "rtapi.h"
#include "rtapi_device.h"

#define RTAPI_PCI_ANY_ID (~0u)
#define RTAPI_PCI_DEVICE(maker, card) \
    .vendor = (maker), .device = (card), .subvendor = RTAPI_PCI_ANY_ID, .subdevice = RTAPI_PCI_ANY_ID
#define RTAPI_PCI_BARS 6

struct rtapi_pci_device_id {
    rtapi_u32 vendor, device, subvendor, subdevice;
    rtapi_u32 class_, class_mask;
    unsigned long driver_data;
};
struct rtapi_pci_resource {
    void *start, *end;
    unsigned long flags;
};
struct rtapi_pci_dev {
    struct rtapi_device dev;
    char dev_name[32];
    char sys_name[32];
    rtapi_u16 vendor, device, subsystem_vendor, subsystem_device;
    unsigned irq;
    struct rtapi_pci_resource resource[RTAPI_PCI_BARS];
    void *driver_data;
};
struct rtapi_pci_driver {
    const char *name;
    const struct rtapi_pci_device_id *id_table;
    int (*probe)(struct rtapi_pci_dev *device, const struct rtapi_pci_device_id *id);
    void (*remove)(struct rtapi_pci_dev *device);
    void *private_data;
};

static inline int rtapi_pci_register_driver(struct rtapi_pci_driver *driver)
{
    rtapi_print_msg(RTAPI_MSG_ERR, "%s: PCI devices are not offered here\n", driver->name);
    return -ENODEV;
}
static inline void rtapi_pci_unregister_driver(struct rtapi_pci_driver *driver) { (void)driver; }
static inline int rtapi_pci_enable_device(struct rtapi_pci_dev *device)
{
    (void)device;
    return -ENODEV;
}
static inline int rtapi_pci_disable_device(struct rtapi_pci_dev *device)
{
    (void)device;
    return 0;
}
static inline void *rtapi_pci_ioremap_bar(struct rtapi_pci_dev *device, int bar)
{
    (void)device;
    (void)bar;
    return NULL;
}
static inline void rtapi_iounmap(volatile void *address) { (void)address; }
#define rtapi_pci_name(device) ((device)->dev_name)
#define rtapi_pci_resource_start(device, bar) ((device)->resource[bar].start)
#define rtapi_pci_resource_end(device, bar) ((device)->resource[bar].end)
#define rtapi_pci_resource_flags(device, bar) ((device)->resource[bar].flags)
#define rtapi_pci_resource_len(device, bar)                            \
    ((size_t)((char *)(device)->resource[bar].end - (char *)(device)->resource[bar].start))
#define rtapi_pci_get_drvdata(device) ((device)->driver_data)
#define rtapi_pci_set_drvdata(device, data) ((device)->driver_data = (data))
#endif

/* The kernel version for components that ask for it: new enough for every interface that they choose by it. */
#ifndef FERRULE_LINUX_VERSION_H
#define FERRULE_LINUX_VERSION_H
#define KERNEL_VERSION(major, minor, patch) (((major) << 16) + ((minor) << 8) + (patch))
#define LINUX_VERSION_CODE KERNEL_VERSION(6, 0, 0)
#endif

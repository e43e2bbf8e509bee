/* Sizes of the motion module, for components that make arrays of them. */
#ifndef MOTION_H
#define MOTION_H
#include "emcpos.h"
#define EMCMOT_MAX_JOINTS 16
#define EMCMOT_MAX_AXIS 9
#define EMCMOT_MAX_SPINDLES 8
#define EMCMOT_MAX_DIO 64
#define EMCMOT_MAX_AIO 64
#endif

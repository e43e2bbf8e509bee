/* Sizes of the motion module. */
#ifndef EMCMOTCFG_H
#define EMCMOTCFG_H
#define EMCMOT_MAX_JOINTS 16
#define EMCMOT_MAX_EXTRAJOINTS EMCMOT_MAX_JOINTS
#define EMCMOT_MAX_AXIS 9
#define EMCMOT_MAX_SPINDLES 8
#define EMCMOT_MAX_DIO 64
#define EMCMOT_MAX_AIO 64
#endif

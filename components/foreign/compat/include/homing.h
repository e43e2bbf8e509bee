/* What a homing module offers to the motion module. It defines all of these functions and names each of them with
 * EXPORT_SYMBOL. */
#ifndef HOMING_H
#define HOMING_H
#include "motion.h"

/* Bits of home_flags. */
#define HOME_IGNORE_LIMITS 1
#define HOME_USE_INDEX 2
#define HOME_IS_SHARED 4
#define HOME_UNLOCK_FIRST 8
#define HOME_ABSOLUTE_ENCODER 16
#define HOME_NO_REHOME 32
#define HOME_NO_FINAL_MOVE 64
#define HOME_INDEX_NO_ENCODER_RESET 128

#ifdef __cplusplus
extern "C" {
#endif
/* Once, as the motion module is loaded: the module keeps the array of joints and makes its pins as those of component
 * id. It returns 0, or a number below 0 if it cannot. */
extern int homing_init(int id, double servo_period, int n_joints, int n_extrajoints,
                       emcmot_joint_t *pjoints);
/* Before that: functions that set and read the lock of a joint. */
extern void homeMotFunctions(void (*pSetRotaryUnlock)(int joint, int unlock),
                             int (*pGetRotaryUnlock)(int joint));

/* Settings of a joint, and those that may change later. */
extern void set_joint_homing_params(int joint, double offset, double home, double home_final_vel,
                                    double home_search_vel, double home_latch_vel, int home_flags,
                                    int home_sequence, bool volatile_home);
extern void update_joint_homing_params(int joint, double offset, double home, int home_sequence);

/* In each servo cycle. do_homing runs in free mode only; it returns true when all joints have just become homed. */
extern void read_homing_in_pins(int n_joints);
extern bool do_homing(void);
extern void write_homing_out_pins(int n_joints);

/* Commands. A joint of -1 means all; set_unhomed also takes -2, those with a volatile home. */
extern void do_home_joint(int joint);
extern void do_cancel_homing(int joint);
extern void set_unhomed(int joint, motion_state_t state);

/* State of all joints, and of one. */
extern bool get_allhomed(void);
extern bool get_homing_is_active(void);
extern int get_home_sequence(int joint);
extern bool get_homing(int joint);
extern bool get_homed(int joint);
extern bool get_index_enable(int joint);
extern bool get_home_needs_unlock_first(int joint);
extern bool get_home_is_idle(int joint);
extern bool get_home_is_synchronized(int joint);
extern bool get_homing_at_index_search_wait(int joint);

/* Says that the module knows the joints as motion.h has them. */
extern __attribute__((weak, visibility("default"))) const char rtapi_info_joint_record[];
__attribute__((used)) const char rtapi_info_joint_record[] = "1";
#ifdef __cplusplus
}
#endif
#endif

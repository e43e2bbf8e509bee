/* The planner of a single joint: the part of its state that a homing module reads and writes. */
#ifndef SIMPLE_TP_H
#define SIMPLE_TP_H

typedef struct simple_tp_t {
    /* Target. */
    double pos_cmd;
    /* Limits. A velocity above the joint's own limit counts as that limit, and the acceleration is always the
     * joint's. */
    double max_vel;
    double max_acc;
    /* 0 brakes to a stop, and the target is then where the joint stands. */
    int enable;
    /* Position and velocity of this cycle. */
    double curr_pos;
    double curr_vel;
    /* Not 0 while the joint moves. */
    int active;
} simple_tp_t;
#endif

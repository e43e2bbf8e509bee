// Numbers of the snapshots `task.status` and `motion.status`.

export const STATE = { estop: 0, off: 1, on: 2 };
export const MODES = ["manual", "auto", "mdi"];
export const MODE_AUTO = 1;
export const INTERPRETER = { idle: 0, reading: 1, paused: 2, waiting: 3 };
/** Kinds of moves. */
export const MOTION = { rapid: 1 };

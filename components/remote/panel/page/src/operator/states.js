// Numbers of the snapshots `task.status` and `motion.status`, and what they say of a machine with or without a task.

export const STATE = { estop: 0, off: 1, on: 2 };
export const MODES = ["manual", "auto", "mdi"];
export const MODE_AUTO = 1;
export const INTERPRETER = { idle: 0, reading: 1, paused: 2, waiting: 3 };
/** Kinds of moves. */
export const MOTION = { rapid: 1 };

/** Returns "estop", "off" or "on"; "none" where nobody knows. Without a task, motion tells it. */
export function powerOf(task, motion) {
  if (task.state !== undefined) return ["estop", "off", "on"][task.state] ?? "none";
  if (motion.enabled === undefined) return "none";
  return motion.estop ? "estop" : motion.enabled ? "on" : "off";
}

/** Returns what a job does, or the path of a machine without a task. */
export function progressOf(task, motion) {
  if (task.interpreter !== undefined) return task.interpreter;
  if (!motion.queue) return INTERPRETER.idle;
  return motion.paused ? INTERPRETER.paused : INTERPRETER.reading;
}

/** Returns whether an axis or a joint may be jogged beside what runs: at rest, or in a pause. */
export const mayJogBeside = (task, motion) => [INTERPRETER.idle, INTERPRETER.paused].includes(progressOf(task, motion));

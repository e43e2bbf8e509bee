// The frame of a part, and the tool in it.

import { about, ofRollPitchYaw, transposed, turned } from "./view/rotation.js";

/** The frame of a part: its zero in machine coordinates, and its rotation about Z in radians. */
export class Frame {
  constructor(zero = [0, 0, 0], angle = 0) {
    [this.zero, this.angle] = [zero, angle];
    [this.cos, this.sin] = [Math.cos(angle), Math.sin(angle)];
  }

  /** Returns a point of the machine in the part's coordinates, in `out`. */
  part(point, out = [0, 0, 0]) {
    for (let i = 0; i < 3; i++) out[i] = point[i] - this.zero[i];
    return this.vector(out, out);
  }

  /** Returns a direction of the machine in the part's coordinates, in `out`. */
  vector(v, out = [0, 0, 0]) {
    const [x, y] = [v[0], v[1]];
    out[0] = x * this.cos + y * this.sin;
    out[1] = y * this.cos - x * this.sin;
    out[2] = v[2];
    return out;
  }

  /** Rotation as nine numbers, row by row: its columns are the part's axes. */
  get turn() {
    return about(2, this.angle);
  }
}

/** The frame of a part that is turned anyhow: X Y Z of its zero, and roll, pitch and yaw in degrees. */
export class FreeFrame extends Frame {
  constructor([x, y, z, a, b, c]) {
    super([x, y, z]);
    this.free = ofRollPitchYaw(a, b, c);
    this.back = transposed(this.free);
  }

  vector(v, out = [0, 0, 0]) {
    turned(this.back, v).forEach((x, i) => { out[i] = x; });
    return out;
  }

  get turn() {
    return this.free;
  }
}

/** Returns the frame of the coordinate system that the task has. */
export function frameOf(task) {
  const angle = ((task.rotation ?? 0) * Math.PI) / 180;
  // G92 is turned with the part.
  const g92 = new Frame([0, 0, 0], -angle).part(task.g92_offset ?? [0, 0, 0]);
  return new Frame((task.g5x_offset ?? [0, 0, 0]).slice(0, 3).map((v, i) => v + g92[i]), angle);
}

/** Returns the pose of the tool in work coordinates: the machine pose without tool, G92, rotation and offset. */
export function workPose(motion, task) {
  const of = (list, i) => list?.[i] ?? 0;
  const tip = (motion.pose ?? []).map((p, i) => p - of(task.tool_offset, i));
  const rest = tip.slice(3).map((p, i) => p - of(task.g5x_offset, i + 3) - of(task.g92_offset, i + 3));
  return tip.length < 3 ? [] : [...frameOf(task).part(tip), ...rest];
}

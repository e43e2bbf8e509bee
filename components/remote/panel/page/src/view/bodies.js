// Bodies of machines, drawn from their kinematics and limits. Each moves with the joints and the pose of the tool.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, ConeGeometry, CylinderGeometry, DirectionalLight, Group, HemisphereLight, Line,
  LineBasicMaterial, Mesh, MeshLambertMaterial, Vector3,
} from "../../vendor/three.module.min.js";

const TRAIL = 4000;
const UP = new Vector3(0, 0, 1);

/** Lights for bodies. */
export function lights() {
  const sun = new DirectionalLight(0xffffff, 1.6);
  sun.position.set(-1, -2, 3);
  return [new HemisphereLight(0xffffff, 0x667788, 1.2), sun];
}

const solid = (color, opacity = 1) => new MeshLambertMaterial({ color, transparent: opacity < 1, opacity });

function box(material, x, y, z) {
  return new Mesh(new BoxGeometry(Math.max(x, 1e-6), Math.max(y, 1e-6), Math.max(z, 1e-6)), material);
}

/** Makes a cylinder that can be laid between two points. */
function rod(material, radius) {
  const mesh = new Mesh(new CylinderGeometry(radius, radius, 1, 10), material);
  mesh.join = (from, to, share = 1) => {
    const way = to.clone().sub(from);
    mesh.position.copy(from).addScaledVector(way, 0.5);
    mesh.scale.set(share, Math.max(way.length(), 1e-6), share);
    mesh.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), way.clone().normalize());
  };
  return mesh;
}

/** The tool: a cone whose tip is the controlled point. */
export class Tool {
  constructor(size, colour) {
    const cone = new Mesh(new ConeGeometry(size * 0.35, size, 20), solid(colour));
    cone.rotation.x = -Math.PI / 2;
    cone.position.z = size / 2;
    this.node = new Group();
    this.node.add(cone);
  }

  /** Puts the tip to a point; the tool points along an axis, or is upright. */
  move(point, axis = null) {
    this.node.position.copy(point);
    this.node.quaternion.setFromUnitVectors(UP, axis ? new Vector3(...axis) : UP);
  }
}

/** The latest way of the tool. */
export class Trail {
  constructor(colour) {
    this.points = new Float32Array(3 * TRAIL);
    this.count = 0;
    this.attribute = new BufferAttribute(this.points, 3);
    const geometry = new BufferGeometry().setAttribute("position", this.attribute);
    this.node = new Line(geometry, new LineBasicMaterial({ color: colour, linewidth: 2 }));
    this.node.frustumCulled = false;
    geometry.setDrawRange(0, 0);
  }

  add(point) {
    const { points } = this;
    const last = 3 * (this.count - 1);
    const isSame = this.count > 0 && point.x === points[last] && point.y === points[last + 1] && point.z === points[last + 2];
    if (isSame) return;
    if (this.count === TRAIL) {
      points.copyWithin(0, 3 * (TRAIL / 4));
      this.count -= TRAIL / 4;
    }
    points.set([point.x, point.y, point.z], 3 * this.count);
    this.count += 1;
    this.attribute.needsUpdate = true;
    this.node.geometry.setDrawRange(0, this.count);
  }

  clear() {
    this.count = 0;
    this.node.geometry.setDrawRange(0, 0);
  }
}

/** A printer, a mill or a gantry: a beam along X that moves in Y, a carriage on it, a quill in Z. */
export class Gantry {
  constructor(low, high, colours) {
    const size = high.clone().sub(low);
    const thick = 0.03 * Math.max(size.x, size.y);
    const [frame, part] = [solid(colours.frame, 0.45), solid(colours.part, 0.7)];
    this.node = new Group();
    this.top = high.z + 2 * thick;
    const bed = box(frame, size.x, size.y, thick / 2);
    bed.position.set((low.x + high.x) / 2, (low.y + high.y) / 2, low.z - thick / 4);
    this.bridge = new Group();
    const beam = box(part, size.x + 4 * thick, thick, thick);
    beam.position.set((low.x + high.x) / 2, 0, this.top);
    this.bridge.add(beam);
    for (const x of [low.x - 1.5 * thick, high.x + 1.5 * thick]) {
      const leg = box(frame, thick, thick, this.top - low.z);
      leg.position.set(x, 0, (this.top + low.z) / 2);
      const rail = box(frame, thick / 2, size.y + 2 * thick, thick / 2);
      rail.position.set(x, (low.y + high.y) / 2, low.z);
      this.bridge.add(leg);
      this.node.add(rail);
    }
    this.carriage = box(part, 2.2 * thick, 1.6 * thick, 1.8 * thick);
    this.quill = rod(part, thick / 3);
    this.node.add(bed, this.bridge, this.carriage, this.quill);
    this.thick = thick;
  }

  move(point) {
    this.bridge.position.y = point.y;
    this.carriage.position.set(point.x, point.y, this.top);
    this.quill.join(new Vector3(point.x, point.y, point.z + this.thick), new Vector3(point.x, point.y, this.top + this.thick));
  }
}

/** A lathe: a spindle along Z at X 0, and a cross slide. */
export class Lathe {
  constructor(low, high, colours) {
    const length = high.z - low.z;
    const radius = Math.max(high.x - low.x, Math.abs(high.x), Math.abs(low.x)) / 2;
    const [frame, part] = [solid(colours.frame, 0.5), solid(colours.part, 0.8)];
    this.node = new Group();
    const chuck = new Mesh(new CylinderGeometry(radius / 2, radius / 2, length / 12, 24), part);
    chuck.rotation.x = Math.PI / 2;
    chuck.position.z = low.z - length / 24;
    const bar = new Mesh(new CylinderGeometry(radius / 5, radius / 5, length / 2, 24), frame);
    bar.rotation.x = Math.PI / 2;
    bar.position.z = low.z + length / 4;
    this.slide = box(part, radius, radius / 6, radius / 6);
    this.reach = radius;
    this.node.add(chuck, bar, this.slide);
  }

  move(point) {
    this.slide.position.set(point.x + this.reach / 2 + this.reach / 8, 0, point.z);
  }
}

/** A machine of straight parts between points: arms, deltas. */
export class Rods {
  constructor(kinematics, size, colours) {
    this.kinematics = kinematics;
    this.material = solid(colours.part, 0.85);
    this.radius = size / 90;
    this.rods = [];
    this.node = new Group();
  }

  /** Takes over other lengths. */
  become(kinematics) {
    this.kinematics = kinematics;
  }

  move(point, joints) {
    const parts = this.kinematics.parts(joints ?? [], point);
    while (this.rods.length < parts.length) {
      this.rods.push(rod(this.material, this.radius));
      this.node.add(this.rods.at(-1));
    }
    this.rods.forEach((r, i) => {
      r.visible = i < parts.length;
      if (r.visible) r.join(...parts[i]);
    });
  }
}

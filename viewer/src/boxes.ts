// Boxes around the dynamic objects of a scan, turned into their direction of motion, and their velocities.
import { css, objectColour, type Colour } from "./colours";
import { DYNAMIC, type Scan, type TrackedObject } from "./drive";
import * as THREE from "three";

export interface ObjectBox {
  object: TrackedObject | null; // null: a label without a row in objects.csv
  number: number;
  centre: THREE.Vector3;
  size: THREE.Vector3;
  heading: number; // about z [rad]
  colour: Colour;
}

// Slower than this, the direction of the velocity is that of its noise.
const LEAST_HEADING_SPEED_MPS = 0.5;
// Points that the turn of a box is found with: enough for its sides, few enough for 45 turns a box at 10 scans a second.
const MOST_FITTED = 200;

export function boxesOf(scan: Scan): ObjectBox[] {
  const of_number = new Map<number, number[]>();
  for (let i = 0; i < scan.header.points; ++i) {
    if (scan.label[i] !== DYNAMIC || scan.object[i] === 0) continue;
    const list = of_number.get(scan.object[i]);
    if (list) list.push(i);
    else of_number.set(scan.object[i], [i]);
  }
  const rows = new Map(scan.header.objects.map((o) => [o.number, o]));
  return [...of_number].map(([number, points]) => boxOf(scan, number, points, rows.get(number) ?? null));
}

// Extent of the points along axes turned by `heading` about z.
function extent(scan: Scan, points: number[], heading: number): { low: THREE.Vector3; high: THREE.Vector3 } {
  const c = Math.cos(heading), s = Math.sin(heading), step = scan.header.step_m;
  const low = new THREE.Vector3(Infinity, Infinity, Infinity), high = low.clone().negate(), p = new THREE.Vector3();
  for (const i of points) {
    const x = scan.xyz[3 * i] * step, y = scan.xyz[3 * i + 1] * step;
    p.set(c * x + s * y, c * y - s * x, scan.xyz[3 * i + 2] * step);
    low.min(p);
    high.max(p);
  }
  return { low, high };
}

// The turn with the smallest ground area, of the four that are alike the one nearest to the direction of motion.
function headingOf(scan: Scan, points: number[], velocity: [number, number, number]): number {
  const few = points.filter((_, k) => k % Math.ceil(points.length / MOST_FITTED) === 0);
  let best = 0, least = Infinity;
  for (let k = 0; k < 45; ++k) {
    const turn = (k * Math.PI) / 90, { low, high } = extent(scan, few, turn), area = (high.x - low.x + 0.1) * (high.y - low.y + 0.1);
    if (area < least) {
      least = area;
      best = turn;
    }
  }
  if (Math.hypot(velocity[0], velocity[1]) < LEAST_HEADING_SPEED_MPS) return best;
  const quarter = Math.PI / 2, motion = Math.atan2(velocity[1], velocity[0]);
  return best + quarter * Math.round((motion - best) / quarter);
}

function boxOf(scan: Scan, number: number, points: number[], object: TrackedObject | null): ObjectBox {
  const heading = headingOf(scan, points, object?.velocity ?? [0, 0, 0]), c = Math.cos(heading), s = Math.sin(heading);
  const { low, high } = extent(scan, points, heading), middle = low.clone().add(high).multiplyScalar(0.5);
  const centre = new THREE.Vector3(c * middle.x - s * middle.y, s * middle.x + c * middle.y, middle.z);
  centre.add(new THREE.Vector3(...scan.header.origin));
  return { object, number, centre, size: high.sub(low).max(new THREE.Vector3(0.2, 0.2, 0.2)), heading, colour: objectColour(number) };
}

const EDGES = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];

export class BoxLayer {
  readonly lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true }));
  private tags: HTMLSpanElement[] = [];
  boxes: ObjectBox[] = [];

  constructor(private readonly holder: HTMLElement) {
    this.lines.frustumCulled = false;
  }

  show(boxes: ObjectBox[], objectColours: boolean): void {
    this.boxes = boxes;
    const positions: number[] = [], colours: number[] = [];
    const add = (p: THREE.Vector3, colour: Colour): void => {
      positions.push(p.x, p.y, p.z);
      const linear = new THREE.Color().setRGB(colour[0] / 255, colour[1] / 255, colour[2] / 255, THREE.SRGBColorSpace);
      colours.push(linear.r, linear.g, linear.b);
    };
    for (const box of boxes) {
      const corners = Array.from({ length: 8 }, (_, k) =>
        new THREE.Vector3(k & 1 ? 0.5 : -0.5, k & 2 ? 0.5 : -0.5, k & 4 ? 0.5 : -0.5)
          .multiply(box.size).applyAxisAngle(new THREE.Vector3(0, 0, 1), box.heading).add(box.centre));
      EDGES.forEach((k) => add(corners[k], box.colour));
      if (box.object) this.arrow(box, (p) => add(p, box.colour));
    }
    this.lines.geometry.dispose();
    this.lines.geometry = new THREE.BufferGeometry();
    this.lines.geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    this.lines.geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
    this.fillTags(objectColours);
  }

  // Where the object is in one second.
  private arrow(box: ObjectBox, add: (p: THREE.Vector3) => void): void {
    const v = new THREE.Vector3(...(box.object?.velocity ?? [0, 0, 0]));
    if (v.length() < 0.3) return;
    const tip = box.centre.clone().add(v), side = new THREE.Vector3(-v.y, v.x, 0).normalize();
    const head = Math.min(1, 0.3 * v.length()), back = tip.clone().addScaledVector(v.clone().normalize(), -head);
    [box.centre, tip, tip, back.clone().addScaledVector(side, head / 2), tip, back.clone().addScaledVector(side, -head / 2)].forEach(add);
  }

  private fillTags(objectColours: boolean): void {
    while (this.tags.length < this.boxes.length) {
      const tag = document.createElement("span");
      this.holder.append(tag);
      this.tags.push(tag);
    }
    this.tags.forEach((tag, k) => {
      const box = this.boxes[k];
      tag.hidden = !box;
      if (!box) return;
      const o = box.object;
      tag.textContent = o ? `${o.id}  ${Math.hypot(...o.velocity).toFixed(1)} m/s` : String(box.number);
      tag.style.borderColor = objectColours ? css(box.colour) : "transparent";
    });
  }

  place(camera: THREE.Camera, width: number, height: number): void {
    this.tags.forEach((tag, k) => {
      const box = this.boxes[k];
      if (!box || !this.lines.visible) {
        tag.style.display = "none";
        return;
      }
      const p = box.centre.clone();
      p.z += box.size.z / 2 + 0.4;
      p.project(camera);
      const shown = p.z < 1 && Math.abs(p.x) < 1 && Math.abs(p.y) < 1;
      tag.style.display = shown ? "" : "none";
      if (shown) tag.style.transform = `translate(${((p.x + 1) / 2) * width}px, ${((1 - p.y) / 2) * height}px) translate(-50%, -100%)`;
    });
  }
}

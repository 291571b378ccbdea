// The 3D scene: camera, clouds, boxes, trail and rays.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { BoxLayer } from "./boxes";
import { Cloud } from "./cloud";
import type { Colour } from "./colours";
import { DYNAMIC, type Scan, type ScanHeader } from "./drive";
import { EyeDome } from "./eye_dome";
import type { Ray } from "./explanations";

export type Follow = "follow" | "turn" | "stand";

// A click this near to a dynamic point, which is drawn large, is on it [CSS pixels].
const DYNAMIC_DOT_PX = 4;
// The mark of the chosen point: a ring that hides nothing.
const RING_PX = 22;
const RING = {
  vertexShader: "uniform float size; void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); gl_PointSize = size; }",
  fragmentShader: `uniform vec3 colour;
void main() {
  float r = 2.0 * length(gl_PointCoord - 0.5);
  float ring = smoothstep(0.66, 0.74, r) * (1.0 - smoothstep(0.9, 1.0, r));
  if (ring < 0.02) discard;
  gl_FragColor = vec4(colour, ring);
}`,
};

const linear = (c: Colour): THREE.Color => new THREE.Color().setRGB(c[0] / 255, c[1] / 255, c[2] / 255, THREE.SRGBColorSpace);

// Rings on the ground about the sensor, as far below it as a lidar on a car's roof stands.
const RING_RADII_M = [10, 20, 30, 40, 60, 80], GROUND_BELOW_M = 1.7;

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera(50, 1, 0.2, 2000);
  readonly orbit: OrbitControls;
  readonly boxes: BoxLayer;
  readonly clouds = new Map<number, Cloud>(); // by index of the scan
  readonly trail: THREE.Line;
  private readonly scene = new THREE.Scene(); // lines, over the points
  private readonly points = new THREE.Scene();
  private readonly eyeDome = new EyeDome();
  private readonly sensor = new THREE.Group();
  private readonly rays = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.85 }));
  private readonly cross = new THREE.Points(new THREE.BufferGeometry(), new THREE.ShaderMaterial({ ...RING, uniforms: { colour: { value: new THREE.Color() }, size: { value: 1 } }, depthTest: false, transparent: true }));
  private readonly grid: THREE.LineSegments;
  private pose: ScanHeader | null = null;
  private dirty = true;

  constructor(canvas: HTMLCanvasElement, tags: HTMLElement, scans: ScanHeader[], light: () => boolean) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: false, powerPreference: "high-performance" });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.autoClear = false;
    this.camera.up.set(0, 0, 1);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.enableDamping = false;
    this.orbit.maxDistance = 800;
    this.orbit.addEventListener("change", () => (this.dirty = true));
    this.boxes = new BoxLayer(tags);
    const track = scans.map((s) => new THREE.Vector3(...s.position));
    this.trail = new THREE.Line(new THREE.BufferGeometry().setFromPoints(track), new THREE.LineBasicMaterial({ color: linear([222, 208, 50]) }));
    this.trail.frustumCulled = this.rays.frustumCulled = this.cross.frustumCulled = false;
    this.cross.visible = false;
    this.cross.renderOrder = 2;
    this.grid = this.rings();
    this.sensor.add(this.grid, this.arrowhead());
    this.scene.add(this.trail, this.sensor, this.boxes.lines, this.rays, this.cross);
    this.ground(light());
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  private rings(): THREE.LineSegments {
    const points: THREE.Vector3[] = [];
    for (const r of RING_RADII_M) {
      for (let k = 0; k < 96; ++k) {
        for (const a of [k, k + 1]) points.push(new THREE.Vector3(r * Math.cos((a * Math.PI) / 48), r * Math.sin((a * Math.PI) / 48), -GROUND_BELOW_M));
      }
    }
    return new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ transparent: true, opacity: 0.5 }));
  }

  private arrowhead(): THREE.Mesh {
    const shape = new THREE.Shape([new THREE.Vector2(1.4, 0), new THREE.Vector2(-0.8, 0.75), new THREE.Vector2(-0.4, 0), new THREE.Vector2(-0.8, -0.75)]);
    return new THREE.Mesh(new THREE.ShapeGeometry(shape), new THREE.MeshBasicMaterial({ color: linear([222, 208, 50]), side: THREE.DoubleSide }));
  }

  ground(light: boolean): void {
    // The shader's colours go to the screen as they are.
    const [r, g, b] = light ? [0.965, 0.969, 0.976] : [0.043, 0.055, 0.075];
    this.renderer.setClearColor(0x000000, 1);
    this.eyeDome.setBack(r, g, b);
    (this.grid.material as THREE.LineBasicMaterial).color.set(light ? 0xb9c3cf : 0x27303c);
    (this.cross.material as THREE.ShaderMaterial).uniforms.colour.value.set(light ? 0x000000 : 0xffffff);
    (this.cross.material as THREE.ShaderMaterial).uniforms.size.value = RING_PX * this.renderer.getPixelRatio();
    this.dirty = true;
  }

  changed(): void {
    this.dirty = true;
  }

  private resize(): void {
    const { clientWidth: w, clientHeight: h } = this.renderer.domElement;
    if (w === 0 || h === 0) return;
    this.renderer.setSize(w, h, false);
    const ratio = this.renderer.getPixelRatio();
    this.eyeDome.resize(Math.round(w * ratio), Math.round(h * ratio), 1.5 * ratio);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.dirty = true;
  }

  // Shows these scans and forgets the others.
  setScans(scans: Scan[]): void {
    const wanted = new Set(scans.map((s) => s.index));
    for (const [index, cloud] of this.clouds) {
      if (wanted.has(index)) continue;
      this.points.remove(cloud.points);
      cloud.dispose();
      this.clouds.delete(index);
    }
    for (const scan of scans) {
      if (this.clouds.has(scan.index)) continue;
      const cloud = new Cloud(scan);
      this.clouds.set(scan.index, cloud);
      this.points.add(cloud.points);
    }
    this.dirty = true;
  }

  moveSensor(to: ScanHeader, follow: Follow): void {
    const from = this.pose ?? to, p = new THREE.Vector3(...to.position), q = new THREE.Quaternion(...to.quaternion);
    this.sensor.position.copy(p);
    this.sensor.quaternion.copy(q);
    if (follow !== "stand" && this.pose) {
      const before = new THREE.Vector3(...from.position), turn = follow === "turn" ? yaw(to) - yaw(from) : 0;
      for (const v of [this.camera.position, this.orbit.target]) v.sub(before).applyAxisAngle(this.camera.up, turn).add(p);
      this.orbit.update();
    }
    this.pose = to;
    this.dirty = true;
  }

  lookFrom(offset: [number, number, number], target: [number, number, number]): void {
    if (!this.pose) return;
    const p = new THREE.Vector3(...this.pose.position), a = yaw(this.pose), up = this.camera.up;
    this.camera.position.set(...offset).applyAxisAngle(up, a).add(p);
    this.orbit.target.set(...target).applyAxisAngle(up, a).add(p);
    this.orbit.update();
    this.dirty = true;
  }

  zoom(factor: number): void {
    this.camera.position.sub(this.orbit.target).multiplyScalar(factor).add(this.orbit.target);
    this.orbit.update();
    this.dirty = true;
  }

  // About the vertical through the target [rad].
  turn(angle: number): void {
    this.camera.position.sub(this.orbit.target).applyAxisAngle(this.camera.up, angle).add(this.orbit.target);
    this.orbit.update();
    this.dirty = true;
  }

  placeOf(scan: Scan, i: number): [number, number, number] {
    return [0, 1, 2].map((a) => scan.header.origin[a] + scan.xyz[3 * i + a] * scan.header.step_m) as [number, number, number];
  }

  // The point nearest to a place on the canvas [CSS pixels]; of two about as near, the nearer to the camera.
  pick(scan: Scan, x: number, y: number): number {
    const { clientWidth: w, clientHeight: h } = this.renderer.domElement;
    this.camera.updateMatrixWorld();
    const o = scan.header.origin, s = scan.header.step_m;
    const m = new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse)
      .multiply(new THREE.Matrix4().makeTranslation(...o)).multiply(new THREE.Matrix4().makeScale(s, s, s)).elements;
    let best = -1, bestCost = Infinity;
    for (let i = 0; i < scan.header.points; ++i) {
      const px = scan.xyz[3 * i], py = scan.xyz[3 * i + 1], pz = scan.xyz[3 * i + 2];
      const cw = m[3] * px + m[7] * py + m[11] * pz + m[15];
      if (cw <= 0.1) continue;
      const dx = (((m[0] * px + m[4] * py + m[8] * pz + m[12]) / cw + 1) / 2) * w - x;
      const dy = ((1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / cw) / 2) * h - y;
      const near = scan.label[i] === DYNAMIC ? DYNAMIC_DOT_PX : 0, beyond = Math.max(0, Math.hypot(dx, dy) - near), away = beyond * beyond;
      if (away > 100) continue;
      const cost = away + 0.15 * cw;
      if (cost < bestCost) {
        bestCost = cost;
        best = i;
      }
    }
    return best;
  }

  choose(place: [number, number, number] | null, rays: Ray[]): void {
    this.cross.visible = place !== null;
    if (place) this.cross.geometry.setAttribute("position", new THREE.Float32BufferAttribute(place, 3));
    const positions: number[] = [], colours: number[] = [];
    for (const ray of rays) {
      const colour = linear(ray.colour);
      positions.push(...ray.from, ...ray.to);
      for (let k = 0; k < 2; ++k) colours.push(colour.r, colour.g, colour.b);
    }
    this.rays.geometry.dispose();
    this.rays.geometry = new THREE.BufferGeometry();
    this.rays.geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    this.rays.geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
    this.dirty = true;
  }

  // Draws if anything has changed.
  draw(): boolean {
    if (!this.dirty) return false;
    this.dirty = false;
    this.eyeDome.render(this.renderer, this.points, this.camera);
    this.renderer.render(this.scene, this.camera);
    const { clientWidth: w, clientHeight: h } = this.renderer.domElement;
    this.boxes.place(this.camera, w, h);
    return true;
  }
}

function yaw(s: ScanHeader): number {
  const [x, y, z, w] = s.quaternion;
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

// The points of one scan on the graphics card.
import * as THREE from "three";
import { colourPoints, type ColourMode } from "./colours";
import type { Scan } from "./drive";

const VERTEX = `
attribute vec4 paint;
uniform float step_m, static_px, dynamic_px, ghost, pixel_ratio;
varying vec3 colour;
void main() {
  float kind = floor(paint.a * 255.0 + 0.5);
  bool dynamic = kind > 1.5;
  vec4 p = modelViewMatrix * vec4(position * step_m, 1.0);
  gl_Position = projectionMatrix * p;
  float near = clamp(38.0 / max(1.0, -p.z), 0.75, 1.9);
  gl_PointSize = (dynamic ? dynamic_px : static_px) * near * pixel_ratio;
  // Another scan than the current one shows its static points; its dynamic points too if ghost is 2.
  if ((dynamic && (ghost > 0.5 && ghost < 1.5 || dynamic_px == 0.0)) || (!dynamic && static_px == 0.0)) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  if (dynamic) gl_Position.z -= 0.0004 * gl_Position.w;
  colour = paint.rgb * (ghost > 0.5 && dynamic ? 0.62 : 1.0);
}`;
const FRAGMENT = `
varying vec3 colour;
void main() {
  vec2 d = gl_PointCoord - 0.5;
  if (dot(d, d) > 0.25) discard;
  gl_FragColor = vec4(colour, 1.0);
}`;

export interface CloudStyle {
  mode: ColourMode;
  light: boolean;
  lasers: number;
  staticSize: number;
  dynamicSize: number;
}

export class Cloud {
  readonly points: THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private readonly paint: THREE.BufferAttribute;
  private painted = "";

  constructor(readonly scan: Scan) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(scan.xyz, 3, false));
    this.paint = new THREE.BufferAttribute(new Uint8Array(4 * scan.header.points), 4, true);
    geometry.setAttribute("paint", this.paint);
    const uniforms = { step_m: { value: scan.header.step_m }, static_px: { value: 1 }, dynamic_px: { value: 1 }, ghost: { value: 0 }, pixel_ratio: { value: 1 } };
    this.points = new THREE.Points(geometry, new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms }));
    this.points.frustumCulled = false;
    this.points.position.set(...scan.header.origin);
  }

  // ghost: 0 the current scan, 1 another one without its dynamic points, 2 with them.
  dress(style: CloudStyle, ghost: number, pixelRatio: number): void {
    const paint = `${style.mode} ${style.light}`;
    if (paint !== this.painted) {
      colourPoints(this.scan, style.mode, style.light, style.lasers, this.paint.array as Uint8Array);
      this.paint.needsUpdate = true;
      this.painted = paint;
    }
    const u = this.points.material.uniforms;
    u.static_px.value = style.staticSize;
    u.dynamic_px.value = style.dynamicSize;
    u.ghost.value = ghost;
    u.pixel_ratio.value = pixelRatio;
  }

  get colours(): Uint8Array {
    return this.paint.array as Uint8Array;
  }

  dispose(): void {
    this.points.geometry.dispose();
    this.points.material.dispose();
  }
}

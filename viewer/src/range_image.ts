// The scan as its sensor saw it: rows are lasers, columns azimuths, straight ahead in the middle.
import { AS_DYNAMIC } from "./colours";
import type { Scan } from "./drive";

export class RangeImage {
  private scan: Scan | null = null;
  private cells = new Int32Array(0); // index of the point, -1: none
  private rows = 0;
  private columns = 0;
  private cellOfPoint = new Int32Array(0);
  private image: ImageData | null = null;

  constructor(readonly canvas: HTMLCanvasElement, private readonly lasers: number) {}

  show(scan: Scan, colours: Uint8Array, light: boolean): void {
    const context = this.canvas.getContext("2d")!;
    this.scan = scan;
    this.rows = this.lasers;
    this.columns = scan.header.columns;
    this.canvas.width = this.columns;
    this.canvas.height = this.rows;
    this.fillCells(scan);
    this.image = context.createImageData(this.columns, this.rows);
    const out = this.image.data, ground = light ? 240 : 16;
    for (let cell = 0; cell < this.cells.length; ++cell) {
      const i = this.cells[cell];
      out[4 * cell + 3] = 255;
      if (i < 0) {
        out[4 * cell] = out[4 * cell + 1] = out[4 * cell + 2] = ground;
        continue;
      }
      const dynamic = colours[4 * i + 3] === AS_DYNAMIC;
      const near = dynamic ? 1 : this.nearness(scan, i, light);
      for (let c = 0; c < 3; ++c) out[4 * cell + c] = colours[4 * i + c] * near;
    }
    context.putImageData(this.image, 0, 0);
  }

  private nearness(scan: Scan, i: number, light: boolean): number {
    const r = Math.hypot(scan.xyz[3 * i], scan.xyz[3 * i + 1], scan.xyz[3 * i + 2]) * scan.header.step_m;
    const near = 1 - Math.min(1, Math.log(Math.max(1, r)) / Math.log(100));
    return light ? 1.5 - 0.7 * near : 0.35 + 1.25 * near;
  }

  // By azimuth about the sensor's up, straight ahead in the middle: lasers do not fire into one direction.
  private fillCells(scan: Scan): void {
    const [qx, qy, qz, qw] = scan.header.quaternion, { origin, position, step_m } = scan.header;
    const forward = [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qz * qw), 2 * (qx * qz - qy * qw)];
    const left = [2 * (qx * qy - qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz + qx * qw)];
    this.cells = new Int32Array(this.rows * this.columns).fill(-1);
    this.cellOfPoint = new Int32Array(scan.header.points);
    for (let i = 0; i < scan.header.points; ++i) {
      const x = scan.xyz[3 * i] * step_m + origin[0] - position[0], y = scan.xyz[3 * i + 1] * step_m + origin[1] - position[1];
      const z = scan.xyz[3 * i + 2] * step_m + origin[2] - position[2];
      const azimuth = Math.atan2(left[0] * x + left[1] * y + left[2] * z, forward[0] * x + forward[1] * y + forward[2] * z);
      const column = Math.min(this.columns - 1, Math.floor((0.5 - azimuth / (2 * Math.PI)) * this.columns));
      this.cells[(this.cellOfPoint[i] = (this.rows - 1 - scan.laser[i]) * this.columns + Math.max(0, column))] = i;
    }
    // Two points may share a cell, which leaves the next one empty.
    for (let cell = this.cells.length - 2; cell > 0; --cell) {
      if (this.cells[cell] < 0 && this.cells[cell - 1] >= 0 && this.cells[cell + 1] >= 0) this.cells[cell] = this.cells[cell - 1];
    }
  }

  // The point at a place of the canvas in CSS pixels, or the nearest one within a few cells; -1: none.
  pointAt(x: number, y: number): number {
    const column = Math.floor((x / this.canvas.clientWidth) * this.columns), row = Math.floor((y / this.canvas.clientHeight) * this.rows);
    for (let reach = 0; reach <= 4; ++reach) {
      for (let d = -reach; d <= reach; ++d) {
        for (const [r, c] of [[row, column + d], [row + Math.sign(d), column + d]]) {
          if (r < 0 || r >= this.rows) continue;
          const i = this.cells[r * this.columns + ((c + this.columns) % this.columns)];
          if (i >= 0) return i;
        }
      }
    }
    return -1;
  }

  // The next point in a direction from point i, or the one in the middle if i is -1.
  next(i: number, right: number, down: number): number {
    if (i < 0) return this.pointAt(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2);
    let column = this.cellOfPoint[i] % this.columns, row = Math.floor(this.cellOfPoint[i] / this.columns);
    for (let step = 0; step < this.columns; ++step) {
      column = (column + right + this.columns) % this.columns;
      row += down;
      if (row < 0 || row >= this.rows) return i;
      const found = this.cells[row * this.columns + column];
      if (found >= 0 && found !== i) return found;
    }
    return i;
  }

  mark(i: number): void {
    if (!this.scan || !this.image) return;
    const context = this.canvas.getContext("2d")!;
    context.putImageData(this.image, 0, 0);
    if (i < 0) return;
    const cell = this.cellOfPoint[i], x = cell % this.columns, y = Math.floor(cell / this.columns);
    const wide = Math.max(2, Math.round(this.columns / 500));
    context.strokeStyle = "#ffffff";
    context.lineWidth = wide;
    context.strokeRect(x - 5 * wide, y - 4, 10 * wide, 8);
    context.strokeStyle = "#000000";
    context.lineWidth = 1;
    context.strokeRect(x - 5 * wide - wide, y - 5, 12 * wide, 10);
  }
}

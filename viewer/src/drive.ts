import { ScanExplanation, type ExplanationTexts } from "./explanations";

// The drive in this page: its header, and its scans, decoded when they are needed.
// apps/mapless/view/scan_block.hpp has the other end of the encoding.

export interface TrackedObject {
  id: number;
  number: number; // in the labels
  points: number;
  centre: [number, number, number]; // [m], axes of the page
  velocity: [number, number, number]; // [m/s]
  std: [number, number, number]; // standard deviation of the velocity [m/s]
  age: number; // scans since its track began
}

export interface ScanHeader {
  number: number; // in the recording
  time_ns: string;
  duration_s: number;
  columns: number;
  points: number;
  step_m: number; // of the coordinates
  origin: [number, number, number]; // the coordinates count from here
  position: [number, number, number]; // of the sensor at the start of the scan
  quaternion: [number, number, number, number]; // page from sensor
  dynamic: number;
  hits: number;
  false: number;
  missed: number;
  objects: TrackedObject[];
}

export interface DriveHeader {
  explanations?: ExplanationTexts; // undefined: the page explains no point
  explained?: boolean; // by mapless view --serve, on a click
  served?: boolean; // by mapless view --serve: scans are loaded from there, and their headers are whole only then
  version: number;
  program: string;
  recording: string;
  result: string;
  format: string;
  sensor: string;
  lasers: number;
  columns: number;
  truth: boolean;
  poses: boolean;
  stages: string[];
  probability: boolean;
  scans: ScanHeader[];
}

export const UNKNOWN = 0, STATIC = 1, DYNAMIC = 2, NO_TRUTH = 3, UNKNOWN_PROBABILITY = 255;

export interface Scan {
  header: ScanHeader;
  index: number; // in DriveHeader.scans
  xyz: Int16Array; // three per point, in steps of header.step_m
  laser: Uint16Array;
  column: Uint16Array;
  record: Uint32Array; // number of the point in the input
  label: Uint8Array;
  truth: Uint8Array;
  object: Uint16Array;
  stages: Uint8Array | null;
  probability: Uint8Array | null; // that the point moves, times 254; UNKNOWN_PROBABILITY
}

const VERSION = 2;

export class DriveError extends Error {}

export function readHeader(): DriveHeader {
  const text = document.getElementById("drive")?.textContent;
  if (!text) throw new DriveError("There is no drive in this page. Write one with: mapless view IN OUT -o drive.html");
  let header: DriveHeader;
  try {
    header = JSON.parse(text) as DriveHeader;
  } catch {
    throw new DriveError("The description of the drive in this file is damaged. Write the page again with mapless view.");
  }
  if (header.version !== VERSION)
    throw new DriveError(`This file has layout ${String(header.version)}, and its viewer reads ${VERSION}. Write the page again with mapless view.`);
  if (!Array.isArray(header.scans) || header.scans.length === 0)
    throw new DriveError("There is no scan in this file. Write the page again with mapless view.");
  return header;
}

function bytesOfBase64(text: string): Uint8Array<ArrayBuffer> {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function inflate(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function fromServer(path: string, problem: string): Promise<Response> {
  try {
    return await fetch(path);
  } catch {
    throw new DriveError(`${problem}: mapless view --serve has ended. Start it again and load this page anew.`);
  }
}

// apps/mapless/view/drive_page.hpp has the other end.
async function parted(answer: Response): Promise<{ json: object; bytes: Uint8Array<ArrayBuffer> }> {
  const bytes = await answer.arrayBuffer(), size = new DataView(bytes).getUint32(0, true);
  return { json: JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, size))) as object, bytes: new Uint8Array(bytes, 4 + size) };
}

// Reads one plane after another; numbers are zigzag coded differences, low bytes first.
export class Planes {
  private at = 0;
  constructor(private readonly bytes: Uint8Array) {}

  integers(count: number, width: number): Uint32Array {
    const out = new Uint32Array(count);
    const mask = width === 4 ? 0xffffffff : 0xffff;
    let before = 0;
    for (let i = 0; i < count; ++i) {
      let coded = 0;
      for (let b = 0; b < width; ++b) coded |= this.bytes[this.at + b * count + i] << (8 * b);
      coded >>>= 0;
      before = (before + ((coded >>> 1) ^ -(coded & 1))) & mask;
      out[i] = before >>> 0;
    }
    this.at += count * width;
    return out;
  }

  plain(count: number): Uint8Array {
    this.at += count;
    return this.bytes.subarray(this.at - count, this.at);
  }

  get read(): number {
    return this.at;
  }
}

function decode(bytes: Uint8Array, header: ScanHeader, index: number, drive: DriveHeader): Scan {
  const n = header.points, planes = new Planes(bytes);
  const of_laser = planes.integers(drive.lasers, 4);
  const xyz = new Int16Array(3 * n);
  for (let axis = 0; axis < 3; ++axis) {
    const values = planes.integers(n, 2);
    for (let i = 0; i < n; ++i) xyz[3 * i + axis] = values[i];
  }
  const column = Uint16Array.from(planes.integers(n, 2)), record = planes.integers(n, 4);
  const classes = planes.plain(n), object = Uint16Array.from(planes.integers(n, 2));
  const stages = drive.stages.length > 0 ? planes.plain(n) : null;
  const probability = drive.probability ? planes.plain(n) : null;
  if (planes.read !== bytes.length) throw new DriveError("its size is not that of its points");
  const laser = new Uint16Array(n);
  let filled = 0;
  of_laser.forEach((count, l) => laser.fill(l, filled, (filled += count)));
  return { header, index, xyz, laser, column, record, label: classes.map((c) => c & 3), truth: classes.map((c) => (c >> 2) & 3), object, stages, probability };
}

// Decoded scans kept: those shown together, and some before and after for stepping.
const SPARE = 12;

export class Drive {
  private readonly decoded = new Map<number, Promise<Scan>>(); // by index, least recently used first
  private whole = false;
  private waiting: (() => void)[] = [];
  capacity = SPARE;

  constructor(readonly header: DriveHeader) {
    (window as { maplessWhole?: () => void }).maplessWhole = () => this.arrived(true);
    document.addEventListener("DOMContentLoaded", () => this.arrived(true));
    const tick = setInterval(() => (this.whole ? clearInterval(tick) : this.arrived(false)), 50);
  }

  get size(): number {
    return this.header.scans.length;
  }

  keep(together: number): void {
    this.capacity = together + SPARE;
  }

  scan(index: number): Promise<Scan> {
    let found = this.decoded.get(index);
    this.decoded.delete(index);
    found ??= this.load(index).catch((error: unknown) => {
      this.decoded.delete(index); // the next call tries again
      throw error;
    });
    this.decoded.set(index, found);
    for (const oldest of this.decoded.keys()) {
      if (this.decoded.size <= this.capacity) break;
      this.decoded.delete(oldest);
    }
    return found;
  }

  get kept(): number {
    return this.decoded.size;
  }

  private arrived(whole: boolean): void {
    this.whole ||= whole;
    const calls = this.waiting;
    this.waiting = [];
    calls.forEach((call) => call());
  }

  // null: the page has none of this scan, or not at all. Decoded at each call: a click is rare, and they are large.
  // `wait` gets what the server says as long as it has none, and returns whether it is wanted still.
  async explanation(scan: Scan, wait: (note: string) => boolean): Promise<ScanExplanation | null> {
    if (this.header.explained) return this.fetchedExplanation(scan, wait);
    const texts = this.header.explanations;
    if (!texts) return null;
    const id = `explain-${scan.header.number}`;
    while (!this.whole && !document.getElementById(id)?.nextElementSibling) await new Promise<void>((resolve) => this.waiting.push(resolve));
    const text = document.getElementById(id)?.textContent;
    return text ? new ScanExplanation(await inflate(bytesOfBase64(text)), scan, this.header, texts) : null;
  }

  // The browser may still be reading the file.
  private async text(number: number): Promise<string> {
    for (;;) {
      const element = document.getElementById(`scan-${number}`);
      // An element is whole once the next one has begun.
      if (element && (this.whole || element.nextElementSibling)) return element.textContent ?? "";
      if (this.whole) throw new DriveError("it is not there: the file was cut off");
      await new Promise<void>((resolve) => this.waiting.push(resolve));
    }
  }

  private async fetched(header: ScanHeader): Promise<Uint8Array> {
    const answer = await fromServer(`scan/${header.number}`, `Scan ${header.number} cannot be loaded`);
    if (!answer.ok) throw new DriveError(`Scan ${header.number} cannot be loaded: ${await answer.text()}`);
    const { json, bytes } = await parted(answer);
    Object.assign(header, json);
    return bytes;
  }

  private async fetchedExplanation(scan: Scan, wait: (note: string) => boolean): Promise<ScanExplanation | null> {
    for (;;) {
      const answer = await fromServer(`explain/${scan.header.number}`, "The point cannot be explained");
      if (answer.status === 200) {
        const { json, bytes } = await parted(answer);
        return new ScanExplanation(await inflate(bytes), scan, this.header, json as ExplanationTexts);
      }
      if (!wait(await answer.text()) || answer.status !== 202) return null;
      await new Promise((done) => setTimeout(done, 200));
    }
  }

  private async load(index: number): Promise<Scan> {
    const header = this.header.scans[index];
    if (this.header.served) return decode(await this.fetched(header), header, index, this.header);
    try {
      const text = await this.text(header.number);
      return decode(await inflate(bytesOfBase64(text)), header, index, this.header);
    } catch (error) {
      const reason = error instanceof DriveError ? error.message : "its data are damaged";
      throw new DriveError(`Scan ${header.number} cannot be shown: ${reason}. Write the page again with mapless view.`);
    }
  }
}

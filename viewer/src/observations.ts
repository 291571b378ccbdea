// What the rays of other scans saw at the place of a chosen point: per scan its ray that passes nearest.
// Shown for the eye: the detector uses every ray's own pose, and its own reference scans and thresholds.
import type { Drive, Scan } from "./drive";

export interface Observation {
  scan: number; // number in the recording
  after_s: number; // negative: an earlier scan
  beyond_m: number; // by how much the ray went on behind the place; negative: it ended before
  angle_rad: number; // between the ray and the direction of the place
  from: [number, number, number];
  to: [number, number, number];
}

// The reference scans of the detector lie up to 6.4 s back, each twice as far as another; and the next scan.
const OFFSETS = [-64, -32, -16, -8, -4, -3, -2, -1, 1];
const WIDEST_RAD = 0.02;

export async function observationsAt(drive: Drive, scan: Scan, place: [number, number, number]): Promise<Observation[]> {
  const out: Observation[] = [];
  for (const offset of OFFSETS) {
    const index = scan.index + offset;
    if (index < 0 || index >= drive.size) continue;
    const seen = observe(await drive.scan(index), scan, place);
    if (seen) out.push(seen);
  }
  return out;
}

// Between the pose at its start and that at the next scan's, which is near enough for the eye.
function observe(other: Scan, scan: Scan, place: [number, number, number]): Observation | null {
  const { position: from, origin, step_m } = other.header;
  const d = place.map((p, a) => p - from[a]), distance = Math.hypot(...d), offset = from.map((p, a) => p - origin[a]);
  let best = -1, bestCosine = Math.cos(WIDEST_RAD), bestRange = 0;
  for (let i = 0; i < other.header.points; ++i) {
    const x = other.xyz[3 * i] * step_m - offset[0], y = other.xyz[3 * i + 1] * step_m - offset[1], z = other.xyz[3 * i + 2] * step_m - offset[2];
    const dot = x * d[0] + y * d[1] + z * d[2];
    if (dot <= 0) continue;
    const range = Math.sqrt(x * x + y * y + z * z), cosine = dot / (range * distance);
    if (cosine > bestCosine) {
      bestCosine = cosine;
      bestRange = range;
      best = i;
    }
  }
  if (best < 0) return null;
  const to = [0, 1, 2].map((a) => origin[a] + other.xyz[3 * best + a] * step_m) as [number, number, number];
  const after_s = Number(BigInt(other.header.time_ns) - BigInt(scan.header.time_ns)) * 1e-9;
  return { scan: other.header.number, after_s, beyond_m: bestRange - distance, angle_rad: Math.acos(Math.min(1, bestCosine)), from, to };
}

// Closer than this to the place, a ray saw a surface there.
export const SURFACE_WITHIN_M = 0.4;

export function inWords(o: Observation): string {
  if (o.beyond_m > SURFACE_WITHIN_M) return `through, ${o.beyond_m.toFixed(1)} m farther`;
  if (o.beyond_m < -SURFACE_WITHIN_M) return `ended ${(-o.beyond_m).toFixed(1)} m before`;
  return "a surface here";
}

// Why points have their labels, as the detector recorded it. apps/mapless/view/explanation_block.hpp has the other end.
import { FALSE, HIT, MISSED, MOVING, UNJUDGED, type Colour } from "./colours";
import { DriveError, Planes, type DriveHeader, type Scan } from "./drive";

export interface ReasonText {
  name: string;
  text: string; // with names of figures in braces
}

export interface ExplanationTexts {
  observations: ReasonText[];
  steps: ReasonText[];
  decisions: ReasonText[];
  limits: Record<string, string>;
}

// About a proposed object in this scan.
export interface Decision {
  id: number;
  moves: boolean;
  reason: number;
  evidence: number;
  required: number;
  displacement: number;
  speed: number;
  std: number;
  points: number;
  age: number;
}

// Of a reference scan about a point.
export interface Observation {
  scan: number; // number in the recording
  after_s: number | null; // null: the scan is not in this page
  votes: number;
  name: string;
  text: string;
  colour: Colour | null; // null: nothing to draw
  beyond_m: number; // where its ray ended, behind the place
  agrees: boolean;
}

export interface PointExplanation {
  step: ReasonText; // filled in, as all texts here
  source: number; // the return whose observations these are
  past: number;
  future: number;
  observations: Observation[]; // by time
  object: { decision: Decision; reason: ReasonText } | null;
}

const AGREES = 16, NOT_KNOWN = 65535, EDGE = 3, THROUGH = 4;
const GREY: Colour = [136, 136, 136];
// Of an ObservationKind, by a function: colours.ts is read after this file.
const colourOf = (kind: number): Colour | null => [null, null, null, null, MOVING, MOVING, MOVING, MISSED, UNJUDGED, GREY, GREY, HIT, FALSE, MISSED][kind] ?? null;
const NOTHING_MET = 6, SURFACE = 7, SLOW_SURFACE = 13, OWN_VEHICLE = 0;
const MAY_BE_SLOW = 128; // in the byte of a step
const SHOWN_WITHOUT_RETURN_M = 30; // of a ray that met nothing, behind the place

const filledIn = (text: string, figures: Record<string, string>): string => text.replace(/\{(\w+)\}/g, (_, name: string) => figures[name] ?? "?");

// Of one reference scan, by rank of the return.
interface Seen { code: Uint8Array; votes: number[]; distance: Uint16Array; aside: Uint8Array }

function readSeen(planes: Planes, count: number, votes: number[]): Seen {
  const code = planes.plain(count), distance = new Uint16Array(count), aside = new Uint8Array(count);
  const placed: number[] = [], free: number[] = [];
  code.forEach((c, at) => {
    const kind = c & (AGREES - 1);
    if (kind >= EDGE) placed.push(at);
    if (kind >= THROUGH && kind <= NOTHING_MET) free.push(at);
  });
  const low = planes.plain(placed.length), high = planes.plain(placed.length), asides = planes.plain(free.length);
  placed.forEach((at, k) => (distance[at] = low[k] | (high[k] << 8)));
  free.forEach((at, k) => (aside[at] = asides[k]));
  return { code, votes, distance, aside };
}

// Steps of a distance: centimetres, from 100 on decimetres (explain/reasons.hpp).
const metres = (steps: number): number => (steps < 100 ? steps / 100 : (steps - 90) / 10);
const metresText = (steps: number): string => metres(steps).toFixed(steps < 100 ? 2 : 1);

export class ScanExplanation {
  private readonly source: Uint32Array;
  private readonly step: Uint8Array;
  private readonly proposed: Uint32Array;
  private readonly support: Uint32Array;
  private readonly supporters: Uint8Array;
  private readonly near: Uint8Array;
  private readonly rank: Uint32Array; // of returns with observations of their own
  private readonly seen: Seen[];
  private readonly gaps: number[];
  private readonly objects: Decision[];

  constructor(bytes: Uint8Array, private readonly scan: Scan, private readonly drive: DriveHeader, private readonly texts: ExplanationTexts) {
    const n = scan.header.points, size = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    const json = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size))) as { gaps: number[]; votes: number[][]; objects: Decision[] };
    this.gaps = json.gaps;
    this.objects = json.objects;
    const planes = new Planes(bytes.subarray(4 + size));
    this.source = planes.integers(n, 4);
    this.step = planes.plain(n);
    this.proposed = planes.integers(n, 2);
    this.support = planes.integers(n, 2);
    this.supporters = planes.plain(n);
    this.near = planes.plain(n);
    this.rank = new Uint32Array(n);
    let own = 0;
    for (let i = 0; i < n; ++i) if (this.source[i] === i) this.rank[i] = own++;
    this.seen = this.gaps.map((_, k) => readSeen(planes, own, json.votes[k]));
    if (planes.read !== bytes.length - 4 - size) throw new DriveError("its explanations are damaged");
  }

  of(i: number): PointExplanation {
    const step_of = this.step[i] % MAY_BE_SLOW, slow = this.step[i] >= MAY_BE_SLOW;
    const observations = step_of === OWN_VEHICLE ? [] : this.gaps.map((gap, k) => this.observation(this.seen[k], this.rank[this.source[i]], gap, slow));
    observations.sort((a, b) => a.scan - b.scan);
    const sum = (later: boolean): number => observations.reduce((s, o) => s + ((o.scan > this.scan.header.number) === later ? o.votes : 0), 0);
    const past = sum(false), future = sum(true), support = this.support[i] > 32767 ? this.support[i] - 65536 : this.support[i];
    const figures = { ...this.texts.limits, votes: String(past + future), support: String(support), supporters: String(this.supporters[i]), near: String(this.near[i]) };
    const step = this.texts.steps[step_of], decision = this.objects[this.proposed[i] - 1];
    return { step: { name: step.name, text: filledIn(step.text, figures) }, source: this.source[i], past, future, observations,
             object: decision ? { decision, reason: this.reason(decision) } : null };
  }

  private observation(seen: Seen, at: number, gap: number, slow: boolean): Observation {
    const code = seen.code[at], agrees = (code & AGREES) !== 0, number = this.scan.header.number - gap;
    const coded_kind = code & (AGREES - 1), forgiven = slow && Math.abs(gap) === 1 && coded_kind === SURFACE && !agrees;
    const kind = forgiven ? SLOW_SURFACE : coded_kind;
    const coded = seen.distance[at], known = coded !== NOT_KNOWN, behind = (coded & 1) === 1, distance = known ? metresText(coded >> 1) : "";
    const off = !known ? "a neighbouring ray ends on it" : `the nearest ray ends ${distance} m ${behind ? "behind it" : "before the point"}`;
    const figures = { ...this.texts.limits, beyond: distance, short: distance, distance, aside: metresText(seen.aside[at]), off };
    const other = this.drive.scans.find((s) => s.number === number), words = this.texts.observations[kind];
    const text = filledIn(words.text, figures) + (agrees ? "; the ranges of the scans change steadily, as of a surface moving along the rays" : "");
    const beyond_m = kind === NOTHING_MET ? SHOWN_WITHOUT_RETURN_M : known ? metres(coded >> 1) * (behind ? 1 : -1) : 0;
    return { scan: number, votes: forgiven ? 0 : seen.votes[code], name: words.name, text, colour: colourOf(kind), beyond_m, agrees,
             after_s: other ? Number(BigInt(other.time_ns) - BigInt(this.scan.header.time_ns)) * 1e-9 : null };
  }

  private reason(d: Decision): ReasonText {
    const words = this.texts.decisions[d.reason];
    const figures = { ...this.texts.limits, evidence: d.evidence.toFixed(0), required: d.required.toFixed(0), displacement: d.displacement.toFixed(2),
                      speed: d.speed.toFixed(2), std: d.std.toFixed(2) };
    return { name: words.name, text: filledIn(words.text, figures) };
  }
}

export interface Ray {
  from: [number, number, number];
  to: [number, number, number];
  colour: Colour;
}

// The rays of the scans in the page, from the sensor at the start of each scan, which is near enough for the eye.
export function raysOf(explanation: PointExplanation, place: [number, number, number], drive: DriveHeader): Ray[] {
  return explanation.observations.flatMap((o) => {
    const header = drive.scans.find((s) => s.number === o.scan);
    if (!header || !o.colour) return [];
    const d = place.map((p, a) => p - header.position[a]), length = Math.max(1e-6, Math.hypot(...d)), reach = 1 + o.beyond_m / length;
    return [{ from: header.position, to: d.map((v, a) => header.position[a] + v * reach) as [number, number, number], colour: o.colour }];
  });
}

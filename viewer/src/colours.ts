// Colours that colour-blind people tell apart (Okabe and Ito 2008), on dark and on light ground.
import { DYNAMIC, STATIC, UNKNOWN, UNKNOWN_PROBABILITY, type Scan } from "./drive";

export type Colour = [number, number, number]; // 0 to 255
export type ColourMode = "motion" | "object" | "truth" | "height" | "laser" | "range" | "probability";

export const MODES: [ColourMode, string][] = [
  ["object", "by object"], ["motion", "by motion"], ["truth", "against truth"],
  ["height", "by height"], ["laser", "by laser"], ["range", "by range"],
  ["probability", "by probability"],
];

export const HIT: Colour = [0, 178, 130], FALSE: Colour = [235, 100, 20], MISSED: Colour = [86, 180, 233];
export const UNJUDGED: Colour = [204, 121, 167], MOVING: Colour = [240, 165, 20];
const OBJECTS: Colour[] = [
  [240, 165, 20], [86, 180, 233], [0, 178, 130], [235, 100, 20], [214, 130, 178], [222, 208, 50], [70, 130, 240], [160, 220, 120],
];
// Cividis, ten of its 256 colours (Nunez, Anderton, Renslow 2018).
const RAMP: Colour[] = [
  [0, 48, 111], [38, 65, 110], [69, 83, 108], [95, 100, 109], [115, 117, 116], [138, 134, 120], [165, 156, 116], [194, 178, 105], [225, 201, 87], [254, 232, 56],
];

export function objectColour(number: number): Colour {
  return number === 0 ? MOVING : OBJECTS[(number - 1) % OBJECTS.length];
}

export function ramp(fraction: number): Colour {
  const at = Math.min(Math.max(fraction, 0), 1) * (RAMP.length - 1), low = Math.min(Math.floor(at), RAMP.length - 2), f = at - low;
  return [0, 1, 2].map((c) => RAMP[low][c] * (1 - f) + RAMP[low + 1][c] * f) as Colour;
}

export const css = (c: Colour): string => `rgb(${c.map(Math.round).join(" ")})`;

// What a point is drawn as: static points are small and below, dynamic ones large.
export const HIDDEN = 0, AS_STATIC = 1, AS_DYNAMIC = 2;

const HEIGHT_FROM_M = -2.5, HEIGHT_TO_M = 6, FAR_M = 80;

// A static point: grey, lighter the higher it is, with a breath of blue.
function grey(z: number, light: boolean): Colour {
  const h = Math.min(Math.max((z - HEIGHT_FROM_M) / (HEIGHT_TO_M - HEIGHT_FROM_M), 0), 1);
  const g = light ? 150 - 95 * h : 74 + 120 * Math.sqrt(h);
  return [g * 0.9, g * 0.97, Math.min(255, g * 1.1)];
}

function truthColour(label: number, truth: number): Colour | null {
  if (truth === DYNAMIC) return label === DYNAMIC ? HIT : MISSED;
  if (label !== DYNAMIC) return null;
  return truth === STATIC ? FALSE : UNJUDGED;
}

// Four bytes per point: colour, and HIDDEN, AS_STATIC or AS_DYNAMIC.
export function colourPoints(scan: Scan, mode: ColourMode, light: boolean, lasers: number, out: Uint8Array): void {
  const { header, xyz, label, truth, object, laser, probability } = scan;
  for (let i = 0; i < header.points; ++i) {
    const x = xyz[3 * i] * header.step_m, y = xyz[3 * i + 1] * header.step_m, z = xyz[3 * i + 2] * header.step_m;
    const dynamic = label[i] === DYNAMIC;
    let colour: Colour | null = null;
    if (mode === "truth") colour = truthColour(label[i], truth[i]);
    else if (mode === "motion" && dynamic) colour = MOVING;
    else if (mode === "object" && dynamic) colour = objectColour(object[i]);
    else if (mode === "height") colour = ramp((z - HEIGHT_FROM_M) / (HEIGHT_TO_M - HEIGHT_FROM_M));
    else if (mode === "laser") colour = ramp(laser[i] / Math.max(1, lasers - 1));
    else if (mode === "probability" && probability && probability[i] !== UNKNOWN_PROBABILITY) colour = ramp(probability[i] / 254);
    else if (mode === "range") colour = ramp(Math.log(1 + Math.hypot(x, y, z)) / Math.log(1 + FAR_M));
    const large = mode === "truth" ? colour !== null : dynamic;
    colour ??= label[i] === UNKNOWN ? grey(z - 2, light) : grey(z, light);
    out[4 * i] = colour[0];
    out[4 * i + 1] = colour[1];
    out[4 * i + 2] = colour[2];
    out[4 * i + 3] = large ? AS_DYNAMIC : AS_STATIC;
  }
}

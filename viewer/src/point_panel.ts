// What the page says of a chosen point.
import { css, FALSE, HIT, MISSED, MOVING, objectColour } from "./colours";
import { DYNAMIC, STATIC, type DriveHeader, type Scan } from "./drive";
import { inWords, type Observation } from "./observations";

const escape = (text: string): string => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

function verdict(scan: Scan, i: number): string {
  const label = scan.label[i], truth = scan.truth[i];
  const word = label === DYNAMIC ? "dynamic" : label === STATIC ? "static" : "unknown";
  const colour = label === DYNAMIC ? objectColour(scan.object[i]) : [140, 150, 165] as const;
  let text = `<span class="dot" style="background:${css([...colour] as [number, number, number])}"></span>labelled <b>${word}</b>`;
  if (truth === DYNAMIC || truth === STATIC) {
    const right = (truth === DYNAMIC) === (label === DYNAMIC);
    const mark = right ? (truth === DYNAMIC ? HIT : null) : truth === DYNAMIC ? MISSED : FALSE;
    text += `; the truth is ${truth === DYNAMIC ? "dynamic" : "static"}${mark ? ` <span class="dot" style="background:${css(mark)}"></span>` : ""}`;
  }
  return text;
}

function stepsTable(scan: Scan, i: number, names: string[]): string {
  if (!scan.stages) return "";
  const mask = scan.stages[i];
  const rows = names.map((name, s) => `<tr><td>${s + 1}. ${escape(name)}</td><td>${(mask >> s) & 1 ? "dynamic" : "static"}</td></tr>`);
  rows.push(`<tr><td>${names.length + 1}. track of the object</td><td><b>${scan.label[i] === DYNAMIC ? "dynamic" : "static"}</b></td></tr>`);
  return `<h3>After each step</h3><table>${rows.join("")}</table>`;
}

// Speed over the scans in this page, with twice its standard deviation.
function speedPlot(header: DriveHeader, scan: Scan, id: number): string {
  const samples = header.scans.flatMap((s, k) => {
    const o = s.objects.find((other) => other.id === id);
    return o ? [{ k, v: Math.hypot(...o.velocity), sd: Math.hypot(...o.std) / Math.sqrt(3) }] : [];
  });
  if (samples.length < 2) return "";
  const first = samples[0].k, last = samples[samples.length - 1].k, top = Math.max(2, ...samples.map((s) => s.v)) * 1.25;
  const x = (k: number): string => (30 + (265 * (k - first)) / Math.max(1, last - first)).toFixed(1);
  const y = (v: number): string => (50 - 44 * Math.min(1, Math.max(0, v / top))).toFixed(1);
  const upper = samples.map((s) => `${x(s.k)},${y(s.v + 2 * s.sd)}`), lower = samples.map((s) => `${x(s.k)},${y(s.v - 2 * s.sd)}`).reverse();
  const line = samples.map((s) => `${x(s.k)},${y(s.v)}`).join(" "), colour = css(objectColour(((id - 1) % 65535) + 1));
  return `<svg viewBox="0 0 300 56" role="img" aria-label="Speed over time"><polygon points="${[...upper, ...lower].join(" ")}" fill="${colour}" opacity=".25"/>
<polyline points="${line}" fill="none" stroke="${colour}" stroke-width="1.6"/><line x1="${x(scan.index)}" x2="${x(scan.index)}" y1="4" y2="50" stroke="currentColor" stroke-dasharray="2 2"/>
<text x="0" y="12" font-size="9" fill="currentColor">${top.toFixed(0)} m/s</text><text x="18" y="52" font-size="9" fill="currentColor">0</text></svg>`;
}

function objectPart(header: DriveHeader, scan: Scan, i: number): string {
  if (scan.object[i] === 0) return "";
  const o = scan.header.objects.find((other) => other.number === scan.object[i]);
  if (!o) return `<h3>Object ${scan.object[i]}</h3>`;
  return `<h3>Object ${o.id}</h3><p>${Math.hypot(...o.velocity).toFixed(2)} m/s, standard deviation per axis
${o.std.map((s) => s.toFixed(2)).join(", ")} m/s; ${o.points} points; followed for ${o.age} scans</p>${speedPlot(header, scan, o.id)}`;
}

export function observationRows(observations: Observation[]): string {
  if (observations.length === 0) return "";
  const rows = observations.map((o) => `<tr><td>${o.scan}</td><td>${o.after_s > 0 ? "+" : ""}${o.after_s.toFixed(1)} s</td><td>${inWords(o)}</td></tr>`);
  return `<h3>What rays of other scans saw here (scan, time)</h3><table>${rows.join("")}</table>
<p><span class="dot" style="background:${css(MOVING)}"></span>through <span class="dot" style="background:${css(MISSED)}"></span>on it <span class="dot" style="background:#888"></span>short</p>`;
}

export function pointPanel(header: DriveHeader, scan: Scan, i: number, observations: Observation[]): string {
  const s = scan.header.step_m, place = [0, 1, 2].map((a) => scan.xyz[3 * i + a] * s), range = Math.hypot(...place);
  return `<button class="close" aria-label="Close" title="Close (Esc)">&times;</button><h2>Point ${scan.record[i]} of scan ${scan.header.number}</h2>
<p>${verdict(scan, i)}</p><p>laser ${scan.laser[i]}, column ${scan.column[i]}, ${range.toFixed(2)} m from the sensor</p>
${objectPart(header, scan, i)}${stepsTable(scan, i, header.stages)}${observationRows(observations)}`;
}

// What the page says of a chosen point.
import { css, FALSE, HIT, MISSED, objectColour, type Colour } from "./colours";
import { DYNAMIC, STATIC, UNKNOWN_PROBABILITY, type DriveHeader, type Scan } from "./drive";
import type { Observation, PointExplanation } from "./explanations";

const escape = (text: string): string => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
const dot = (colour: Colour): string => `<span class="dot" style="background:${css(colour)}"></span>`;
const signed = (n: number): string => (n > 0 ? `+${n}` : n < 0 ? `\u2212${-n}` : "0");

function verdict(scan: Scan, i: number): string {
  const label = scan.label[i], truth = scan.truth[i];
  const word = label === DYNAMIC ? "dynamic" : label === STATIC ? "static" : "unknown";
  const colour: Colour = label === DYNAMIC ? objectColour(scan.object[i]) : [140, 150, 165];
  let text = `${dot(colour)}labelled <b>${word}</b>`;
  if (truth === DYNAMIC || truth === STATIC) {
    const right = (truth === DYNAMIC) === (label === DYNAMIC);
    const mark = right ? (truth === DYNAMIC ? HIT : null) : truth === DYNAMIC ? MISSED : FALSE;
    text += `; the truth is ${truth === DYNAMIC ? "dynamic" : "static"} ${mark ? dot(mark) : ""}`;
  }
  const p = scan.probability?.[i] ?? UNKNOWN_PROBABILITY;
  return p === UNKNOWN_PROBABILITY ? text : `${text}<br>It moves with probability ${(p / 254).toFixed(2)}.`;
}

// The step that decided, and what led there.
function reasons(e: PointExplanation, scan: Scan): string {
  const part = `<p>${escape(e.step.text)}</p>`;
  if (!e.object) return `<h3>Decided by: ${escape(e.step.name)}</h3>${part}`;
  const { decision: d, reason } = e.object;
  return `<h3>Decided by its object: ${escape(reason.name)}</h3><p>${escape(reason.text)}</p>
<h3>Part of ${d.id ? `object ${d.id}` : "a static object"} by: ${escape(e.step.name)}</h3>${part}
${d.moves ? "" : `<p class="faint">${d.points} points, followed for ${d.age} scan${d.age === 1 ? "" : "s"}, static in scan ${scan.header.number}</p>`}`;
}

function row(o: Observation): string {
  const when = o.after_s === null ? "" : `${o.after_s > 0 ? "+" : "\u2212"}${Math.abs(o.after_s).toFixed(1)} s`;
  return `<tr title="scan ${o.scan}"><td>${when || `scan ${o.scan}`}</td><td class="votes">${signed(o.votes)}</td><td>${o.colour ? dot(o.colour) : `<span class="dot none"></span>`}</td><td>${escape(o.text)}</td></tr>`;
}

function rays(e: PointExplanation, scan: Scan, i: number): string {
  if (e.observations.length === 0) return "";
  const of_other = e.source === i ? "" : `<p class="faint">No scan was queried about it: it has the evidence of point ${scan.record[e.source]} of the same surface.</p>`;
  return `<h3>What the rays of other scans saw here</h3>${of_other}<table class="rays">${e.observations.map(row).join("")}
<tr class="sum"><td>sum</td><td class="votes">${signed(e.past + e.future)}</td><td></td><td>${signed(e.past)} of earlier scans, ${signed(e.future)} of later ones</td></tr></table>`;
}

function stepsTable(scan: Scan, i: number, names: string[]): string {
  if (!scan.stages) return "";
  const mask = scan.stages[i];
  const states = names.map((name, s): [string, boolean] => [name, ((mask >> s) & 1) === 1]);
  states.push(["track of the object", scan.label[i] === DYNAMIC]);
  return `<h3>After each step</h3><ol class="steps">${states.map(([name, on]) => `<li class="${on ? "on" : ""}">${escape(name)}<b>${on ? "dynamic" : "static"}</b></li>`).join("")}</ol>`;
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
<text x="0" y="12">${top.toFixed(0)} m/s</text><text x="0" y="52">0</text></svg>`;
}

function objectPart(header: DriveHeader, scan: Scan, i: number): string {
  if (scan.object[i] === 0) return "";
  const o = scan.header.objects.find((other) => other.number === scan.object[i]);
  if (!o) return `<h3>Object ${scan.object[i]}</h3>`;
  return `<h3>Object ${o.id} over time</h3><p>${Math.hypot(...o.velocity).toFixed(2)} m/s, standard deviation per axis
${o.std.map((s) => s.toFixed(2)).join(", ")} m/s; ${o.points} points; followed for ${o.age} scans</p>${speedPlot(header, scan, o.id)}`;
}

export function pointPanel(header: DriveHeader, scan: Scan, i: number, explanation: PointExplanation | null): string {
  const s = scan.header.step_m, place = [0, 1, 2].map((a) => scan.xyz[3 * i + a] * s), range = Math.hypot(...place);
  const command = `mapless explain ${header.recording} ${header.result || "OUT"} --scan ${scan.header.number} --point ${scan.record[i]}`;
  const why = explanation ? `${reasons(explanation, scan)}${rays(explanation, scan, i)}` : '<p class="faint note"></p>';
  return `<button class="close" aria-label="Close" title="Close (Esc)">&times;</button><h2>Point ${scan.record[i]} of scan ${scan.header.number}</h2>
<p>${verdict(scan, i)}</p><p class="faint">laser ${scan.laser[i]}, column ${scan.column[i]}, ${range.toFixed(2)} m from the sensor</p>
${why}${objectPart(header, scan, i)}${stepsTable(scan, i, header.stages)}
${explanation || (header.served && header.result) ? `<h3>${explanation ? "As text" : "Why it has its label"}</h3><code>${escape(command)}</code>` : ""}`;
}

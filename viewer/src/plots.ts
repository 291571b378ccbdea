// The plots of the page of `mapless benchmark`, drawn by uPlot. Each is a figure of class "plot" with its numbers in it
// as JSON; apps/mapless/benchmark/page/plot.hpp has the other end.
import uPlot from "uplot";

interface Axis {
  name: string;
  from: number;
  to: number;
  step: number; // of the ticks
}

interface Line {
  name: string;
  colour: string;
  dashed: boolean;
  points: [number, number][];
  names: string[]; // none, or one per point, written beside it
}

interface Plot {
  title: string;
  x: Axis;
  y: Axis;
  lines: Line[];
}

const HEIGHT = 380, NEAR = 30; // [px]
const number = (v: number): string => String(Number(v.toPrecision(4)));
const colour = (name: string) => (): string => getComputedStyle(document.documentElement).getPropertyValue(name);

function axisOf(axis: Axis, side: number): uPlot.Axis {
  const ticks = Array.from({ length: Math.floor((axis.to - axis.from) / axis.step + 1e-6) + 1 }, (_, k) => axis.from + k * axis.step);
  return {
    scale: side === 2 ? "x" : "y", side, label: axis.name, labelSize: 24, size: side === 2 ? 30 : 48, splits: () => ticks, values: (_, at) => at.map(number),
    stroke: colour("--soft"), grid: { stroke: colour("--line"), width: 1 }, ticks: { show: false }, font: "13px system-ui, sans-serif", labelFont: "13px system-ui, sans-serif",
  };
}

// A curve over recall may turn back, so each line has x values of its own.
const curve: uPlot.Series.PathBuilder = (u, line) => {
  const stroke = new Path2D(), fill = new Path2D(), [xs, ys] = (u.data as unknown as [number[], number[]][])[line];
  const radius = (u.series[line].dash ? 2.2 : 3.2) * devicePixelRatio;
  xs.forEach((x, k) => {
    const at: [number, number] = [u.valToPos(x, "x", true), u.valToPos(ys[k], "y", true)];
    k === 0 ? stroke.moveTo(...at) : stroke.lineTo(...at);
    fill.moveTo(at[0] + radius, at[1]);
    fill.arc(...at, radius, 0, 2 * Math.PI);
  });
  return { stroke, fill };
};

function writeNames(u: uPlot, lines: Line[]): void {
  u.ctx.save();
  u.ctx.textAlign = "left";
  u.ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  lines.forEach((line, k) => {
    if (!u.series[k + 1].show) return;
    u.ctx.fillStyle = line.colour;
    line.names.forEach((name, i) => u.ctx.fillText(name, u.valToPos(line.points[i][0], "x", true) + 7 * devicePixelRatio, u.valToPos(line.points[i][1], "y", true) - 7 * devicePixelRatio));
  });
  u.ctx.restore();
}

// The point under the mouse, or chosen by the arrow keys, in words.
class Tip {
  private readonly box = document.createElement("output");
  private chosen = -1;

  constructor(private readonly u: uPlot, private readonly plot: Plot) {
    this.box.className = "tip";
    this.box.hidden = true;
    u.over.append(this.box);
    u.over.tabIndex = 0;
    u.over.setAttribute("role", "application");
    u.over.setAttribute("aria-label", `${plot.title}. The arrow keys go from point to point.`);
    u.over.addEventListener("mousemove", (e) => this.show(this.near(e.offsetX, e.offsetY)));
    for (const leave of ["mouseleave", "blur"]) u.over.addEventListener(leave, () => this.show(-1));
    u.over.addEventListener("keydown", (e) => {
      const way = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[e.key], count = this.points().length;
      if (!way || count === 0) return;
      this.show((Math.max(this.chosen, way > 0 ? -1 : 0) + way + count) % count);
      e.preventDefault();
    });
  }

  private points(): { line: Line; k: number; at: [number, number] }[] {
    const shown = this.plot.lines.filter((_, k) => this.u.series[k + 1].show);
    return shown.flatMap((line) => line.points.map(([x, y], k) => ({ line, k, at: [this.u.valToPos(x, "x"), this.u.valToPos(y, "y")] as [number, number] })));
  }

  private near(x: number, y: number): number {
    let best = -1, least = NEAR;
    this.points().forEach(({ at }, k) => {
      const far = Math.hypot(at[0] - x, at[1] - y);
      if (far < least) [best, least] = [k, far];
    });
    return best;
  }

  private show(index: number): void {
    this.chosen = index;
    this.box.hidden = index < 0;
    if (index < 0) return;
    const { line, k, at } = this.points()[index], [x, y] = line.points[k], { plot } = this;
    this.box.textContent = `${line.name}${line.names[k] ? `, ${line.names[k]}` : ""}: ${plot.x.name} ${number(x)}, ${plot.y.name} ${number(y)}`;
    this.box.style.transform = `translate(${at[0] > this.u.over.clientWidth / 2 ? "-100%" : "0"}, -100%)`;
    [this.box.style.left, this.box.style.top] = [`${at[0]}px`, `${at[1] - 8}px`];
  }
}

function draw(figure: HTMLElement): void {
  const plot = JSON.parse(figure.querySelector("script")!.textContent!) as Plot;
  const series: uPlot.Series[] = plot.lines.map((line) => ({
    label: line.name, stroke: line.colour, fill: line.colour, width: 2, ...(line.dashed ? { dash: [6, 6] } : {}),
    paths: curve, points: { show: false }, facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }],
  }));
  const options: uPlot.Options = {
    mode: 2, title: plot.title, width: figure.clientWidth, height: HEIGHT,
    scales: { x: { time: false, range: [plot.x.from, plot.x.to] }, y: { range: [plot.y.from, plot.y.to] } },
    axes: [axisOf(plot.x, 2), axisOf(plot.y, 3)], series: [{}, ...series],
    legend: { live: false, markers: { dash: (_, k) => (plot.lines[k - 1].dashed ? "dashed" : "solid") } }, cursor: { drag: { x: false, y: false }, points: { show: false }, x: false, y: false },
    hooks: { draw: [(u) => writeNames(u, plot.lines)] },
  };
  const data = [null, ...plot.lines.map((line) => [line.points.map((p) => p[0]), line.points.map((p) => p[1])])];
  const u = new uPlot(options, data as unknown as uPlot.AlignedData, figure);
  new Tip(u, plot);
  figure.querySelectorAll<HTMLElement>(".u-legend th").forEach((entry) => {
    entry.tabIndex = 0;
    entry.title = "Show or hide the line (Enter)";
    entry.addEventListener("keydown", (e) => { if (e.key === "Enter") entry.click(); });
  });
  new ResizeObserver(() => u.setSize({ width: figure.clientWidth, height: HEIGHT })).observe(figure);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => u.redraw());
}

document.querySelectorAll<HTMLElement>("figure.plot").forEach(draw);

// The page: reads the drive in it, and lets the user play, turn and ask.
import { boxesOf } from "./boxes";
import { css, FALSE, HIT, MISSED, MODES, MOVING, objectColour, ramp, UNJUDGED, type ColourMode } from "./colours";
import { Drive, DriveError, readHeader, type Scan } from "./drive";
import { raysOf } from "./explanations";
import { pointPanel } from "./point_panel";
import { RangeImage } from "./range_image";
import { Stage, type Follow } from "./stage";

const at = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
const select = (id: string): HTMLSelectElement => at<HTMLSelectElement>(id), input = (id: string): HTMLInputElement => at<HTMLInputElement>(id);

function complain(error: unknown): void {
  at("message").textContent = error instanceof Error ? error.message : String(error);
  at("message").hidden = false;
}

const TOGETHER = [1, 2, 3, 5, 10, 20, 50];
const KEYS: [string, string, string][] = [ // key, meaning, the element it works
  [" ", "play, pause", "play"], ["n", "one scan on", "next"], ["b", "one scan back", "back"], ["h", "behind the sensor", "home"], ["t", "from above", "above"],
  ["g", "dynamic points of all scans shown", "ghosts"], ["o", "boxes and velocities", "boxes"], ["l", "trajectory", "trail"], ["i", "range image", "image"],
  ["p", "fold the panel", "fold"], ["s", "save a picture", "shot"], ["c", "copy a link to this view", "link"], ["d", "dark or light", "theme"], ["?", "these keys", "help-button"],
];

class Viewer {
  private readonly header = readHeader();
  private readonly drive = new Drive(this.header);
  private light = matchMedia("(prefers-color-scheme: light)").matches;
  private readonly stage = new Stage(at("view"), at("tags"), this.header.scans, () => this.light);
  private readonly range = new RangeImage(at("range"), this.header.lasers);
  private current: Scan | null = null;
  private wanted = 0;
  private showing = false;
  private playing = false;
  private due = 0; // when the next scan is to be shown [ms]
  private chosen = -1;
  private keepCamera = false;
  private linkedPoint = ""; // by a link: number of the point in the input

  start(): void {
    const { header } = this;
    at("title").querySelector("h1")!.textContent = header.recording.replace(/\/+$/, "").split("/").slice(-1)[0];
    document.title = `${header.recording} \u2013 mapless view`;
    select("colour").innerHTML = MODES.filter(([m]) => (m !== "truth" || header.truth) && (m !== "probability" || header.probability)).map(([m, name]) => `<option value="${m}">${name}</option>`).join("");
    if (header.truth) select("colour").value = "truth";
    select("together").innerHTML = TOGETHER.filter((n) => n === 1 || n <= header.scans.length).map((n) => `<option>${n}</option>`).join("");
    input("scrub").max = String(this.drive.size - 1);
    at("help").querySelector("table")!.innerHTML = KEYS.map(([key, what]) => `<tr><td>${key === " " ? "space" : key.toUpperCase()}</td><td>${what}</td></tr>`).join("") +
      "<tr><td>&larr; &rarr;</td><td>ten scans back, on</td></tr><tr><td>Home End</td><td>first, last scan</td></tr><tr><td>+ &minus; [ ]</td><td>nearer, farther, turn</td></tr><tr><td>arrows in the range image</td><td>the next point</td></tr><tr><td>Esc</td><td>forget the chosen point</td></tr>";
    this.listen();
    this.applyTheme();
    this.readLink();
    addEventListener("hashchange", () => { this.readLink(); this.go(this.wanted); });
    this.go(this.wanted);
    const frame = (now: number): void => {
      this.advance(now);
      this.stage.draw();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  private listen(): void {
    const click = (id: string, act: () => void): void => at(id).addEventListener("click", act);
    click("play", () => this.play(!this.playing));
    click("next", () => { this.play(false); this.go(this.wanted + 1); });
    click("back", () => { this.play(false); this.go(this.wanted - 1); });
    click("home", () => this.behind());
    click("above", () => this.stage.lookFrom([-0.01, 0, 85], [0, 0, 0]));
    click("shot", () => this.picture());
    click("link", () => this.copyLink());
    click("theme", () => { this.light = !this.light; this.applyTheme(); this.dress(); });
    click("help-button", () => at<HTMLDialogElement>("help").showModal());
    click("fold", () => at("fold").setAttribute("aria-expanded", String(at("fold").getAttribute("aria-expanded") !== "true")));
    input("scrub").addEventListener("input", () => { this.play(false); this.go(Number(input("scrub").value)); });
    for (const id of ["colour", "static-size", "dynamic-size", "boxes", "trail", "ghosts", "image"]) at(id).addEventListener("input", () => this.dress());
    select("together").addEventListener("input", () => this.go(this.wanted));
    this.listenToPoints();
    addEventListener("keydown", (event) => this.key(event));
  }

  private listenToPoints(): void {
    const view = at<HTMLCanvasElement>("view");
    let down: [number, number] = [0, 0];
    view.addEventListener("pointerdown", (e) => (down = [e.clientX, e.clientY]));
    view.addEventListener("pointerup", (e) => {
      if (e.button !== 0 || Math.hypot(e.clientX - down[0], e.clientY - down[1]) > 4 || !this.current) return;
      this.choose(this.stage.pick(this.current, e.clientX, e.clientY));
    });
    at("range").addEventListener("click", (e) => this.choose(this.range.pointAt(e.offsetX, e.offsetY)));
    at("range").addEventListener("keydown", (e) => {
      const way = ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] } as Record<string, [number, number]>)[e.key];
      if (!way) return;
      this.choose(this.range.next(this.chosen, ...way));
      e.preventDefault();
      e.stopPropagation();
    });
    at("point").addEventListener("click", (e) => { if ((e.target as HTMLElement).className === "close") this.choose(-1); });
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || at<HTMLDialogElement>("help").open) return;
    if (target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && event.key.startsWith("Arrow"))) return;
    if (event.key === " " && (target instanceof HTMLButtonElement || (target instanceof HTMLInputElement && target.type === "checkbox"))) return;
    const jump: Record<string, number> = { ArrowLeft: this.wanted - 10, ArrowRight: this.wanted + 10, Home: 0, End: this.drive.size - 1 };
    const camera: Record<string, () => void> = {
      "+": () => this.stage.zoom(0.8), "-": () => this.stage.zoom(1.25), "[": () => this.stage.turn(0.1), "]": () => this.stage.turn(-0.1),
    };
    if (event.key in jump) this.go(jump[event.key]);
    else if (event.key in camera) camera[event.key]();
    else if (event.key === "Escape") this.choose(-1);
    else {
      const found = KEYS.find(([key]) => key === event.key.toLowerCase());
      if (!found) return;
      at(found[2]).click();
    }
    event.preventDefault();
  }

  private play(on: boolean): void {
    this.playing = on;
    at("play").textContent = on ? "Pause" : "Play";
    if (on && this.wanted === this.drive.size - 1) this.go(0);
    this.due = performance.now();
  }

  // Shows the next scan once its time has come and the one before is drawn.
  private advance(now: number): void {
    if (!this.playing || this.showing || now < this.due) return;
    if (this.wanted + 1 >= this.drive.size) return this.play(false);
    const here = this.header.scans[this.wanted], next = this.header.scans[this.wanted + 1];
    const step_ms = Number(BigInt(next.time_ns) - BigInt(here.time_ns)) * 1e-6 / Number(select("speed").value);
    this.due = Math.max(this.due + step_ms, now - step_ms);
    this.go(this.wanted + 1);
  }

  private go(index: number): void {
    this.wanted = Math.min(Math.max(index, 0), this.drive.size - 1);
    input("scrub").value = String(this.wanted);
    if (!this.showing) void this.show();
  }

  // While one scan is being decoded another may be wanted: it is shown next.
  private async show(): Promise<void> {
    this.showing = true;
    try {
      for (;;) {
        const index = this.wanted, together = Number(select("together").value);
        this.drive.keep(together);
        const before = Array.from({ length: together }, (_, k) => index - k).filter((k) => k >= 0);
        const scans = await Promise.all(before.map((k) => this.drive.scan(k)));
        this.present(scans);
        if (this.wanted === index) break;
      }
      for (const ahead of [1, 2, -1]) {
        if (this.wanted + ahead >= 0 && this.wanted + ahead < this.drive.size) this.drive.scan(this.wanted + ahead).catch(() => undefined);
      }
    } catch (error) {
      complain(error);
      this.play(false);
    } finally {
      this.showing = false;
    }
  }

  private present(scans: Scan[]): void {
    const first = this.current === null, scan = scans[0];
    if (this.current !== scan) this.choose(-1);
    this.current = scan;
    this.stage.setScans(scans);
    this.stage.moveSensor(scan.header, select("camera").value as Follow);
    if (first && !this.keepCamera) this.behind();
    this.stage.boxes.show(boxesOf(scan), true);
    this.dress();
    at("message").hidden = true;
    if (this.linkedPoint !== "") this.choose(scan.record.indexOf(Number(this.linkedPoint)));
    this.linkedPoint = "";
    document.documentElement.dataset.scan = String(scan.header.number);
  }

  private behind(): void {
    this.stage.lookFrom([-21, 0, 13], [9, 0, -1]);
  }

  private dress(): void {
    const scan = this.current;
    if (!scan) return;
    const mode = select("colour").value as ColourMode, ghosts = input("ghosts").checked;
    const style = { mode, light: this.light, lasers: this.header.lasers, staticSize: Number(input("static-size").value), dynamicSize: Number(input("dynamic-size").value) };
    for (const cloud of this.stage.clouds.values()) cloud.dress(style, cloud.scan === scan ? 0 : ghosts ? 2 : 1, this.stage.renderer.getPixelRatio());
    this.stage.boxes.lines.visible = input("boxes").checked;
    this.stage.trail.visible = input("trail").checked;
    this.range.canvas.classList.toggle("off", !input("image").checked);
    if (input("image").checked) this.range.show(scan, this.stage.clouds.get(scan.index)!.colours, this.light);
    this.range.mark(this.chosen);
    this.stage.changed();
    this.writeTexts(scan, mode);
    this.chart();
  }

  private writeTexts(scan: Scan, mode: ColourMode): void {
    const { header } = this, h = scan.header, n = (count: number): string => count.toLocaleString("en");
    const seconds = Number(BigInt(h.time_ns) - BigInt(header.scans[0].time_ns)) * 1e-9;
    at("clock").textContent = `scan ${h.number}  (${scan.index + 1} of ${this.drive.size})  ${seconds.toFixed(1)} s`;
    at("subtitle").textContent = `${header.sensor}, ${header.format}; ${n(h.points)} points, ${n(h.dynamic)} dynamic, ${h.objects.length} objects${header.poses ? "" : "; no poses"}`;
    const entry = (colour: string, text: string, count?: number): string => `<li><i style="background:${colour}"></i>${text}${count === undefined ? "" : `<b>${n(count)}</b>`}</li>`;
    const bar = (low: string, high: string): string => `<li>${low}<i class="ramp" style="background:linear-gradient(90deg,${Array.from({ length: 6 }, (_, k) => css(ramp(k / 5))).join(",")})"></i>${high}</li>`;
    const rows: Record<ColourMode, () => string> = {
      truth: () => entry(css(HIT), "found", h.hits) + entry(css(FALSE), "false", h.false) + entry(css(MISSED), "missed", h.missed) +
        (h.dynamic > h.hits + h.false ? entry(css(UNJUDGED), "dynamic, truth unknown", h.dynamic - h.hits - h.false) : ""),
      motion: () => entry(css(MOVING), "dynamic", h.dynamic) + entry("#8b95a3", "static", h.points - h.dynamic),
      object: () => entry(`linear-gradient(90deg,${[1, 2, 3].map((k) => css(objectColour(k))).join(",")})`, "dynamic, by object", h.dynamic) + entry("#8b95a3", "static", h.points - h.dynamic),
      height: () => bar("-2.5 m", "6 m"), laser: () => bar("0", String(header.lasers - 1)), range: () => bar("0 m", "80 m"),
      probability: () => bar("0", "1") + entry("#8b95a3", "not known"),
    };
    at("legend").innerHTML = rows[mode]();
  }

  // Dynamic points of every scan, over the slider.
  private chart(): void {
    const canvas = at<HTMLCanvasElement>("chart"), w = (canvas.width = canvas.clientWidth), h = (canvas.height = canvas.clientHeight);
    const context = canvas.getContext("2d")!, most = Math.max(1, ...this.header.scans.map((s) => (s.dynamic ?? 0) + (s.missed ?? 0))), size = this.drive.size;
    const inner = w - 16, wide = Math.max(1, inner / size - 1); // the slider's thumb is 16 px wide
    this.header.scans.forEach((s, k) => {
      const x = 8 + (size > 1 ? (inner * k) / (size - 1) : 0) - wide / 2, bar = (count: number): number => (h * count) / most;
      context.globalAlpha = k === this.wanted ? 1 : 0.55;
      let y = h;
      const parts: [number, string][] = this.header.truth
        ? [[s.hits, css(HIT)], [s.missed, css(MISSED)], [s.false, css(FALSE)]] : [[s.dynamic, css(MOVING)]];
      for (const [count, colour] of parts) {
        context.fillStyle = colour;
        if (count) context.fillRect(x, (y -= bar(count)), wide, bar(count)); // of a served scan unknown until it is loaded
      }
    });
  }

  private choose(i: number): void {
    this.chosen = i;
    const scan = this.current, panel = at("point");
    panel.hidden = i < 0 || !scan;
    this.range.mark(i);
    if (!scan || i < 0) return this.stage.choose(null, []);
    this.play(false);
    const place = this.stage.placeOf(scan, i);
    this.stage.choose(place, []);
    panel.innerHTML = pointPanel(this.header, scan, i, null);
    const here = (): boolean => this.chosen === i && this.current === scan;
    const wait = (note: string): boolean => {
      if (here()) panel.querySelector(".note")!.textContent = note;
      return here();
    };
    this.drive.explanation(scan, wait).then((found) => {
      if (!found || !here()) return;
      const explanation = found.of(i);
      this.stage.choose(place, raysOf(explanation, place, this.header));
      panel.innerHTML = pointPanel(this.header, scan, i, explanation);
    }, complain);
  }

  private applyTheme(): void {
    document.documentElement.classList.toggle("light", this.light);
    at("theme").textContent = this.light ? "Dark" : "Light";
    this.stage.ground(this.light);
  }

  private picture(): void {
    this.stage.changed();
    this.stage.draw();
    const a = document.createElement("a");
    a.href = at<HTMLCanvasElement>("view").toDataURL("image/png");
    a.download = `scan_${this.current?.header.number ?? 0}.png`;
    a.click();
  }

  private link(): string {
    const round = (v: { x: number; y: number; z: number }): string => [v.x, v.y, v.z].map((c) => (Math.round(c * 100) / 100 + 0).toFixed(2)).join(",");
    const view = new URLSearchParams({
      scan: String(this.header.scans[this.wanted].number), eye: round(this.stage.camera.position), target: round(this.stage.orbit.target),
      colour: select("colour").value, camera: select("camera").value, together: select("together").value,
    });
    if (this.current && this.chosen >= 0) view.set("point", String(this.current.record[this.chosen]));
    return `#${view.toString().replaceAll("%2C", ",")}`;
  }

  private copyLink(): void {
    history.replaceState(null, "", this.link());
    void navigator.clipboard?.writeText(location.href).catch(() => undefined);
    at("link").textContent = "Copied";
    setTimeout(() => (at("link").textContent = "Link"), 1200);
  }

  private readLink(): void {
    const view = new URLSearchParams(location.hash.slice(1));
    const vector = (key: string): [number, number, number] | null => {
      const numbers = (view.get(key) ?? "").split(",").map(Number);
      return numbers.length === 3 && numbers.every(Number.isFinite) ? (numbers as [number, number, number]) : null;
    };
    for (const id of ["colour", "camera", "together"]) {
      const value = view.get(id);
      if (value && [...select(id).options].some((o) => o.value === value)) select(id).value = value;
    }
    const index = this.header.scans.findIndex((s) => String(s.number) === view.get("scan"));
    if (index >= 0) this.wanted = index;
    this.linkedPoint = view.get("point") ?? "";
    const eye = vector("eye"), target = vector("target");
    if (!eye || !target) return;
    this.keepCamera = true;
    this.stage.camera.position.set(...eye);
    this.stage.orbit.target.set(...target);
    this.stage.orbit.update();
    // The camera of a link is absolute: what the sensor has moved since does not shift it.
    this.stage.moveSensor(this.header.scans[this.wanted], "stand");
  }

  // For tests: what is kept, and what was drawn.
  get state(): { scan: number; playing: boolean; kept: number; clouds: number; geometries: number; chosen: number } {
    return { scan: this.current?.header.number ?? -1, playing: this.playing, kept: this.drive.kept, clouds: this.stage.clouds.size,
             geometries: this.stage.renderer.info.memory.geometries, chosen: this.chosen };
  }
}

try {
  if (!("DecompressionStream" in window)) throw new DriveError("This browser is too old for this page: it needs Chrome 110, Firefox 113, Safari 16.4 or later.");
  const viewer = new Viewer();
  Object.defineProperty(window, "maplessState", { get: () => viewer.state });
  viewer.start();
} catch (error) {
  const webgl = error instanceof Error && /WebGL/.test(error.message);
  complain(webgl ? new Error("This browser shows no 3D: WebGL is switched off or missing. Try another browser, or switch hardware acceleration on.") : error);
}

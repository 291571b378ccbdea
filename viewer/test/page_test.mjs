// The pages of `mapless view` and `mapless benchmark` in a real browser without a screen.
// usage: CHROMIUM=/usr/bin/chromium MAPLESS=build/mapless node --test test/page_test.mjs
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { get } from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { chromium } from "playwright-core";

const folder = mkdtempSync(join(tmpdir(), "mapless_page_"));
const mapless = (...words) => execFileSync(process.env.MAPLESS, words, { stdio: ["ignore", "pipe", "ignore"] });
const file = (name) => join(folder, name);
const FLAGS = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync"];
let browser;

before(async () => {
  mapless("simulate", "town1", "--sensor", "VLP-16", "--duration-s", "2.5", "--seed", "3", "--world", "level", "-o", file("town"));
  mapless("detect", file("town"), "-o", file("out"), "--probability");
  mapless("view", file("town"), file("out"), "-o", file("drive.html"));
  browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: FLAGS });
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

// Opens a page; whatever it asks of a network, or complains of, is noted.
async function open(name, hash = "") {
  const page = await browser.newPage({ viewport: { width: 900, height: 600 }, colorScheme: "dark" });
  const noted = [];
  page.on("request", (r) => { if (!/^(file|data|blob):/.test(r.url())) noted.push(`request ${r.url()}`); });
  page.on("pageerror", (e) => noted.push(`error ${e.message}`));
  page.on("console", (m) => { if (m.type() === "error") noted.push(`console ${m.text()}`); });
  await page.goto(`file://${file(name)}${hash}`);
  return { page, noted };
}

const state = (page) => page.evaluate(() => window.maplessState);
const shown = (page, scan) => page.waitForFunction((k) => window.maplessState?.scan === k, scan, { timeout: 20000 });

// Number of pixels of an element, else of the 3D view, near each colour.
async function pixels(page, colours, element = page.locator("#view")) {
  const png = (await element.screenshot()).toString("base64");
  return page.evaluate(async ([data, wanted]) => {
    const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const image = context.getImageData(0, 0, bitmap.width, bitmap.height).data;
    return wanted.map((c) => {
      let count = 0;
      for (let i = 0; i < image.length; i += 4) count += c.every((v, k) => Math.abs(v - image[i + k]) < 6) ? 1 : 0;
      return count;
    });
  }, [png, colours]);
}

const HIT = [0, 178, 130], MOVING = [240, 165, 20];

test("draws static and dynamic points in the colours of the chosen mode", async () => {
  const { page, noted } = await open("drive.html", "#scan=20");
  await shown(page, 20);
  for (const id of ["boxes", "trail", "image"]) await page.locator(`#${id}`).uncheck();
  const header = await page.evaluate(() => JSON.parse(document.getElementById("drive").textContent).scans.find((s) => s.number === 20));
  assert.ok(header.hits > 0, "the scene has no dynamic point that was found");
  await page.selectOption("#colour", "truth");
  const [found, none] = await pixels(page, [HIT, MOVING]);
  await page.selectOption("#colour", "motion");
  const [, moving] = await pixels(page, [HIT, MOVING]);
  assert.ok(found > 10 && none === 0 && moving > 10, `${found} pixels found, ${none} moving before, ${moving} after`);
  assert.deepEqual(noted, []);
  await page.close();
});

test("colours by probability", async () => {
  const { page, noted } = await open("drive.html", "#scan=20");
  await shown(page, 20);
  for (const id of ["boxes", "trail", "image"]) await page.locator(`#${id}`).uncheck();
  await page.selectOption("#colour", "probability");
  const p = readFileSync(file("out/probability/000020.f32")), of = (i) => Math.round(254 * p.readFloatLE(4 * i)) / 254;
  const record = Array.from({ length: p.length / 4 }, (_, i) => i).reduce((best, i) => (of(i) > of(best) || Number.isNaN(of(best)) ? i : best), 0);
  assert.ok(of(record) > 8 / 9, "the scene has no point that surely moves");
  // The last two colours of the ramp, of probability 8/9 and 1.
  const part = 9 * of(record) - 8, colour = [225, 201, 87].map((c, k) => c + part * ([254, 232, 56][k] - c));
  const [sure] = await pixels(page, [colour]);
  assert.ok(sure > 10, `${sure} pixels of probability ${of(record)}`);
  assert.match(await page.locator("#legend").innerText(), /not known/);
  const again = await open("drive.html", `#scan=20&point=${record}`);
  const text = `It moves with probability ${of(record).toFixed(2)}.`;
  await again.page.waitForFunction((t) => document.getElementById("point").innerText.includes(t), text);
  assert.deepEqual([...noted, ...again.noted], []);
  await page.close();
  await again.page.close();
});

test("steps, jumps, scrubs and plays", async () => {
  const { page, noted } = await open("drive.html");
  await shown(page, 0);
  await page.keyboard.press("n");
  await shown(page, 1);
  await page.keyboard.press("b");
  await shown(page, 0);
  await page.keyboard.press("End");
  await shown(page, 24);
  await page.locator("#scrub").fill("7");
  await shown(page, 7);
  await page.locator("#view").focus();
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.maplessState.scan > 8, null, { timeout: 20000 });
  await page.keyboard.press("Space");
  assert.equal((await state(page)).playing, false);
  assert.deepEqual(noted, []);
  await page.close();
});

test("a click explains the point under it, in the view and in the range image", async () => {
  const { page, noted } = await open("drive.html", "#scan=20");
  await shown(page, 20);
  await page.locator("#range").click({ position: { x: 430, y: 60 } });
  await page.waitForFunction(() => /Point \d+ of scan 20/.test(document.getElementById("point").innerText));
  assert.match(await page.locator("#point").innerText(), /After each step/);
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#point").isVisible(), false);
  // Straight below the eye, from above, is the ground round the sensor.
  await page.keyboard.press("t");
  for (let x = 380; x <= 620 && (await state(page)).chosen < 0; x += 8) await page.mouse.click(x, 200);
  assert.ok((await state(page)).chosen >= 0);
  await page.waitForFunction(() => /rays of other scans/i.test(document.getElementById("point").innerText));
  assert.deepEqual(noted, []);
  await page.close();
});

// What the page says of its chosen point, against the command.
async function explainedAsByTheCommand(page, scan, record) {
  const said = JSON.parse(mapless("explain", file("town"), file("out"), "--scan", String(scan), "--point", String(record), "--json"));
  await page.waitForFunction(([k, n]) => new RegExp(`Point ${n} of scan ${k}[^]*Decided by`).test(document.getElementById("point").innerText), [scan, record], { timeout: 60000 });
  const text = await page.locator("#point").innerText();
  assert.match(text, new RegExp(`Point ${record} of scan ${scan}\\s+labelled ${said.label}`));
  for (const part of [said.step_text, ...(said.object ? [said.object.text] : []), ...said.observations.map((o) => o.text)])
    assert.ok(text.includes(part), `${part}\nis not in\n${text}`);
  const coloured = await page.locator("#point .rays .dot[style]").count();
  assert.equal(coloured, said.observations.filter((o) => !["not queried", "no ray", "faulty", "edge"].includes(o.kind)).length);
  const votes = await page.locator("#point .rays .votes").allInnerTexts();
  const number = (t) => Number(t.replace("\u2212", "-"));
  assert.deepEqual(votes.slice(0, -1).map(number), said.observations.map((o) => o.votes));
  assert.equal(number(votes.at(-1)), said.votes.total);
}

// Numbers of the points of a scan with a label.
function labelled(scan, wanted) {
  const labels = readFileSync(file(`out/labels/${String(scan).padStart(6, "0")}.label`));
  return Array.from({ length: labels.length / 4 }, (_, i) => i).filter((i) => labels.readUInt16LE(4 * i) === wanted);
}

test("the page explains points as mapless explain does", async () => {
  const dynamic = labelled(20, 251), still = labelled(20, 9);
  assert.ok(dynamic.length > 0, "the scene has no dynamic point");
  for (const record of [dynamic[0], dynamic[dynamic.length >> 1], still[0], still[still.length >> 1], still[still.length - 1]]) {
    const { page, noted } = await open("drive.html", `#scan=20&point=${record}`);
    await explainedAsByTheCommand(page, 20, record);
    assert.deepEqual(noted, []);
    await page.close();
  }
});

// In place of the browser's clock one that a test steps: the time of the page goes on by whole frames.
const STEPPED = () => {
  let now = 0, calls = [];
  performance.now = () => now;
  window.requestAnimationFrame = (call) => calls.push(call);
  window.nextFrame = (ms) => {
    const due = calls;
    calls = [];
    now += ms;
    due.forEach((call) => call(now));
  };
};

test("plays as many scans a second as the data have, times the speed", async () => {
  const page = await browser.newPage({ viewport: { width: 300, height: 300 } });
  await page.addInitScript(STEPPED);
  for (const [speed, scans] of [["1", 10], ["2", 20], ["0.5", 5]]) { // of 10 Hz
    await page.goto("about:blank");
    await page.goto(`file://${file("drive.html")}`);
    await shown(page, 0);
    await page.selectOption("#speed", speed);
    await page.locator("#play").click();
    const seen = await page.evaluate(async () => {
      const scans = new Set();
      for (let frame = 1; frame < 100; ++frame) { // of 10 ms: all but the last of a second
        window.nextFrame(10);
        while (window.maplessState.scan !== Number(document.getElementById("scrub").value)) await new Promise((done) => setTimeout(done, 0));
        scans.add(window.maplessState.scan);
      }
      return [...scans].filter((k) => k > 0);
    });
    assert.deepEqual(seen, Array.from({ length: scans }, (_, k) => k + 1), `at speed ${speed}`);
  }
  await page.close();
});

test("frame times, which are only reported", async (t) => {
  const { page } = await open("drive.html");
  await shown(page, 0);
  const ms = await page.evaluate(async () => {
    const times = [];
    const frame = (now) => { times.push(now); requestAnimationFrame(frame); };
    document.getElementById("play").click();
    requestAnimationFrame(frame);
    while (window.maplessState.playing || window.maplessState.scan < 24) await new Promise((done) => setTimeout(done, 20));
    return times.slice(1).map((at, k) => at - times[k]).sort((a, b) => a - b);
  });
  t.diagnostic(`${ms.length} frames of 900 x 600 while 25 scans play, drawn by software: median ${ms[ms.length >> 1].toFixed(1)} ms, 95 % ${ms[Math.floor(0.95 * ms.length)].toFixed(1)} ms`);
  await page.close();
});

test("a link brings scan, camera and colour back", async () => {
  const { page } = await open("drive.html", "#scan=5");
  await shown(page, 5);
  await page.selectOption("#colour", "height");
  await page.keyboard.press("t");
  await page.locator("#link").click();
  const hash = new URL(page.url()).hash, again = await open("drive.html", hash);
  await shown(again.page, 5);
  assert.equal(await again.page.locator("#colour").inputValue(), "height");
  await again.page.locator("#link").click();
  assert.equal(new URL(again.page.url()).hash, hash);
  await page.close();
  await again.page.close();
});

// STEPS=500 takes a minute with software that draws in place of a graphics card.
const STEPS = Number(process.env.STEPS ?? 60);

test(`memory is flat over ${STEPS} steps`, async (t) => {
  const { page } = await open("drive.html");
  await shown(page, 0);
  await page.setViewportSize({ width: 300, height: 300 })
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("Performance.enable");
  // Shows `count` scans in an order that never finds one decoded, and returns what is in use then.
  const after = async (count) => {
    await page.evaluate(async (steps) => {
      const scrub = document.getElementById("scrub");
      for (let k = 1; k <= steps; ++k) {
        const scan = (k * 13) % 25;
        scrub.value = scan;
        scrub.dispatchEvent(new Event("input"));
        while (window.maplessState.scan !== scan) await new Promise((done) => setTimeout(done, 0));
      }
    }, count);
    for (let k = 0; k < 2; ++k) await devtools.send("HeapProfiler.collectGarbage");
    const { metrics } = await devtools.send("Performance.getMetrics"), of = (name) => metrics.find((m) => m.name === name).value;
    return { bytes: of("JSHeapUsedSize"), nodes: of("Nodes"), ...(await state(page)) };
  };
  // First as many: until some 500 steps the browser still compiles what is used most.
  const before = await after(STEPS), end = await after(STEPS), bytes = `${before.bytes} bytes, ${STEPS} steps later ${end.bytes}`;
  t.diagnostic(bytes);
  assert.ok(end.bytes < before.bytes + 1e6, bytes);
  assert.ok(end.nodes < before.nodes + 100, `${before.nodes} nodes, then ${end.nodes}`);
  assert.ok(end.kept <= 13 && end.clouds === 1 && end.geometries === before.geometries, JSON.stringify(end));
  await page.close();
});

test("the keyboard reaches points, camera and both themes", async () => {
  const { page, noted } = await open("drive.html", "#scan=20");
  await shown(page, 20);
  await page.locator("#range").focus();
  await page.keyboard.press("ArrowRight");
  const first = (await state(page)).chosen;
  assert.ok(first >= 0);
  const place = async () => (await page.locator("#point .faint").first().innerText()).match(/laser (\d+), column (\d+)/).slice(1).map(Number);
  const [laser, column] = await place();
  await page.keyboard.press("ArrowRight");
  const [same, next] = await place();
  assert.ok(same === laser && next !== column && (await state(page)).scan === 20, `laser ${laser} to ${same}, column ${column} to ${next}`);
  await page.keyboard.press("ArrowDown"); // where the ground is
  assert.ok((await place())[0] < laser);
  await page.keyboard.press("Escape");
  await page.locator("#view").focus();
  const far = async () => {
    await page.locator("#link").click();
    const [eye, target] = ["eye", "target"].map((k) => new URLSearchParams(new URL(page.url()).hash.slice(1)).get(k).split(",").map(Number));
    return Math.hypot(...eye.map((e, k) => e - target[k]));
  };
  const before = await far();
  await page.locator("#view").focus();
  await page.keyboard.press("+");
  assert.ok(Math.abs((await far()) - 0.8 * before) < 0.1);
  for (const id of ["boxes", "trail", "image"]) await page.locator(`#${id}`).uncheck();
  const grounds = [[11, 14, 19], [246, 247, 249]];
  const dark = await pixels(page, grounds);
  await page.locator("#view").focus();
  await page.keyboard.press("d");
  const light = await pixels(page, grounds);
  assert.ok(dark[0] > 1000 && dark[1] === 0 && light[0] === 0 && light[1] > 1000, `${dark} pixels of either ground, then ${light}`);
  assert.deepEqual(noted, []);
  await page.close();
});

// Only the browser's own choice of a host differs from a foreign page's request.
const status = (url, path, headers = {}) => new Promise((done) => get(`${url}${path}`, { headers }, (r) => done(r.resume().statusCode)));

test("a served page reads scans as they are shown, from its own address alone", async (t) => {
  const server = spawn(process.env.MAPLESS, ["view", file("town"), file("out"), "--serve"], { stdio: ["ignore", "pipe", "ignore"] });
  t.after(() => server.kill("SIGKILL")); // where the test fails
  const ended = new Promise((done) => server.on("exit", done));
  const line = await new Promise((done) => server.stdout.once("data", (data) => done(String(data))));
  const url = line.match(/http:\/\/127\.0\.0\.1:\d+\//)[0];
  const page = await browser.newPage({ viewport: { width: 900, height: 600 }, colorScheme: "dark" });
  const asked = [], noted = [];
  page.on("request", (r) => asked.push(r.url()));
  page.on("pageerror", (e) => noted.push(e.message));
  page.on("console", (m) => { if (m.type() === "error") noted.push(m.text()); });
  await page.goto(`${url}#scan=20`);
  await shown(page, 20);
  for (const id of ["boxes", "trail", "image"]) await page.locator(`#${id}`).uncheck();
  assert.ok((await pixels(page, [HIT]))[0] > 10);
  await page.keyboard.press("b");
  await shown(page, 19);
  await page.locator("#range").evaluate((e) => e.classList.remove("off"));
  await page.locator("#image").check();
  await page.locator("#range").click({ position: { x: 430, y: 60 } });
  const [, record] = (await page.locator("#point").innerText()).match(/mapless explain \S+ \S+ --scan 19 --point (\d+)/);
  await explainedAsByTheCommand(page, 19, record);
  // An earlier scan: the detector begins anew.
  const early = labelled(4, 9)[100];
  await page.goto(`${url}#scan=4&point=${early}`);
  await explainedAsByTheCommand(page, 4, early);
  assert.deepEqual(noted, []);
  assert.ok(asked.every((a) => a.startsWith(url)) && asked.filter((a) => a.includes("/scan/")).length < 10, asked.join(" "));
  const { host } = new URL(url);
  for (const [path, code] of [["scan/20", 200], ["scan/25", 404], ["scan/", 404], ["scan/2x", 404], ["explain/4", 200], ["explain/25", 404], ["explain/4/1", 404], ["labels/000020.label", 404], ["..%2f..%2fetc/passwd", 404]])
    assert.equal(await status(url, path), code, path);
  assert.equal(await status(url, "", { host: "mapless.example" }), 403);
  assert.equal(await status(url, "", { host: host.replace("127.0.0.1", "localhost") }), 200);
  server.kill("SIGINT");
  assert.equal(await ended, 0);
  await page.keyboard.press("Home");
  await page.waitForFunction(() => /mapless view --serve has ended/.test(document.getElementById("message").innerText));
  await page.close();
});

test("damaged files give a message", async () => {
  const whole = readFileSync(file("drive.html"), "utf8");
  const damaged = {
    "no_drive.html": [whole.replace('id="drive"', 'id="other"'), /no drive in this page/],
    "version.html": [whole.replace('"version":2', '"version":9'), /layout 9/],
    "data.html": [whole.replace(/(id="scan-0">.{4000}).{80}/, (_, start) => start + "A".repeat(80)), /Scan 0 cannot be shown: its data are damaged/],
    "cut.html": [whole.slice(0, whole.indexOf('id="scan-9"')), /Scan 9 cannot be shown: .*cut off/, "#scan=9"],
  };
  for (const [name, [text, message, hash]] of Object.entries(damaged)) {
    writeFileSync(file(name), text);
    const { page } = await open(name, hash);
    await page.waitForFunction(() => !document.getElementById("message").hidden, null, { timeout: 20000 });
    assert.match(await page.locator("#message").innerText(), message);
    await page.close();
  }
});

test("the page of mapless benchmark draws its plots and shows its drives", async () => {
  mapless("benchmark", "--quick", "--scenes", "town1", "--sensors", "VLP-16", "--duration-s", "1", "-o", file("bench"));
  const { page, noted } = await open("bench/index.html");
  const plots = page.locator("figure.plot"), blue = [[0, 114, 178]];
  assert.equal(await plots.count(), 3); // of the threshold, and of the range limit, total and average
  for (const plot of await plots.all()) {
    await plot.scrollIntoViewIfNeeded();
    const canvas = plot.locator("canvas");
    assert.ok((await pixels(page, blue, canvas))[0] > 50);
    await plot.locator(".u-over").focus();
    await page.keyboard.press("ArrowRight");
    assert.match(await plot.locator(".tip").innerText(), /: (recall|range limit \[m\]) [\d.]+, (precision|recall) [\d.]+$/);
    for (const name of await plot.locator(".u-legend th").all()) await name.press("Enter");
    assert.deepEqual(await pixels(page, blue, canvas), [0]);
  }
  await page.locator("summary", { hasText: "town1, VLP-16" }).first().click();
  await page.frameLocator("iframe").locator("#clock").filter({ hasText: /scan \d+/ }).waitFor({ timeout: 20000 });
  assert.deepEqual(noted, []);
  await page.close();
});

// The page of `mapless view` in a real browser without a screen.
// usage: CHROMIUM=/usr/bin/chromium MAPLESS=build/mapless node --test test/page_test.mjs
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
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

// Number of pixels of the 3D view near each colour.
async function pixels(page, colours) {
  const png = (await page.locator("#view").screenshot()).toString("base64");
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

test("the page explains points as mapless explain does", async () => {
  const labels = readFileSync(file("out/labels/000020.label"));
  const of = (wanted) => Array.from({ length: labels.length / 4 }, (_, i) => i).filter((i) => labels.readUInt16LE(4 * i) === wanted);
  const dynamic = of(251), still = of(9);
  assert.ok(dynamic.length > 0, "the scene has no dynamic point");
  for (const record of [dynamic[0], dynamic[dynamic.length >> 1], still[0], still[still.length >> 1], still[still.length - 1]]) {
    const said = JSON.parse(mapless("explain", file("town"), file("out"), "--scan", "20", "--point", String(record), "--json"));
    const { page, noted } = await open("drive.html", `#scan=20&point=${record}`);
    await page.waitForFunction(() => /Decided by/.test(document.getElementById("point").innerText), null, { timeout: 20000 });
    const text = await page.locator("#point").innerText();
    assert.match(text, new RegExp(`Point ${record} of scan 20\\s+labelled ${said.label}`));
    for (const part of [said.step_text, ...(said.object ? [said.object.text] : []), ...said.observations.map((o) => o.text)])
      assert.ok(text.includes(part), `${part}\nis not in\n${text}`);
    const coloured = await page.locator("#point .rays .dot[style]").count();
    assert.equal(coloured, said.observations.filter((o) => !["not queried", "no ray", "faulty", "edge"].includes(o.kind)).length);
    const votes = await page.locator("#point .rays .votes").allInnerTexts();
    const number = (t) => Number(t.replace("\u2212", "-"));
    assert.deepEqual(votes.slice(0, -1).map(number), said.observations.map((o) => o.votes));
    assert.equal(number(votes.at(-1)), said.votes.total);
    assert.deepEqual(noted, []);
    await page.close();
  }
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

test("what is kept does not grow over steps", async () => {
  const { page } = await open("drive.html");
  await shown(page, 0);
  const round = async () => {
    for (const k of [5, 10, 15, 20, 24, 0]) {
      await page.locator("#scrub").fill(String(k));
      await shown(page, k);
    }
    return state(page);
  };
  await round();
  const before = await round();
  for (let k = 0; k < 3; ++k) await round();
  const { kept, clouds, geometries } = await state(page);
  assert.ok(kept <= 13 && clouds === 1, `${kept} scans decoded, ${clouds} clouds`);
  assert.equal(geometries, before.geometries);
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

// Takes the pictures of an animation from pages of `mapless view`, in a headless Chromium.
// usage: node animate.mjs FOLDER PAGE#LINK:FIRST:LAST...   writes FOLDER/0000.png and so on
import { mkdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

const [folder, ...parts] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"] });
let number = 0;
for (const part of parts) {
  const [, file, hash, first, last] = /^([^#]*)(#.*)?:(\d+):(\d+)$/.exec(part);
  const page = await browser.newPage({ viewport: { width: 1000, height: 562 }, colorScheme: "dark" });
  await page.goto(`file://${resolve(file)}${hash ?? ""}`);
  await page.waitForFunction(() => window.maplessState?.scan >= 0);
  await page.addStyleTag({ content: "#panel, #controls, #subtitle { display: none !important; } #range { height: 64px !important; }" });
  for (let k = Number(first); k <= Number(last); ++k) {
    await page.locator("#scrub").evaluate((scrub, scan) => {
      scrub.value = scan;
      scrub.dispatchEvent(new Event("input"));
    }, k);
    await page.waitForFunction((scan) => window.maplessState.scan === scan, k);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    await page.screenshot({ path: join(folder, `${String(number++).padStart(4, "0")}.png`) });
  }
  await page.close();
}
await browser.close();

// Builds the page of `mapless view` from src/ into one HTML file, which is committed.
// usage: node build.mjs [FILE]   default: ../apps/mapless/view/page.html
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "../apps/mapless/view/page.html");
const { outputFiles } = await build({
  entryPoints: [join(here, "src/main.ts")],
  bundle: true,
  minify: true,
  charset: "ascii",
  target: ["chrome110", "firefox113", "safari16.4"],
  legalComments: "none",
  write: false,
});
// A script element ends at the first "</script", wherever that is.
const program = outputFiles[0].text.trimEnd().replaceAll("</script", "<\\/script");
const licence = readFileSync(join(here, "node_modules/three/LICENSE"), "utf8").trim();
const page = readFileSync(join(here, "src/page.html"), "utf8")
  .replace("/*style*/", () => readFileSync(join(here, "src/page.css"), "utf8").trimEnd())
  .replace("<!--licence-->", () => `<!-- three.js, https://threejs.org\n${licence}\n-->`)
  .replace("/*program*/", () => program);
writeFileSync(out, page);

// Builds what the command writes into pages, from src/, as files that are committed: the page of `mapless view`, and
// what draws the plots of the page of `mapless benchmark`.
// usage: node build.mjs [PAGE PLOTS]   default: ../apps/mapless/view/page.html ../apps/mapless/benchmark/page/plots.html
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url)), apps = join(here, "../apps/mapless");
const [page = join(apps, "view/page.html"), plots = join(apps, "benchmark/page/plots.html")] = process.argv.slice(2);
const read = (path) => readFileSync(join(here, path), "utf8").trim();
const licence = (name, url, path) => `<!-- ${name}, ${url}\n${read(path)}\n-->`;

async function program(entry) {
  const { outputFiles } = await build({
    entryPoints: [join(here, entry)],
    bundle: true,
    minify: true,
    charset: "ascii",
    target: ["chrome110", "firefox113", "safari16.4"],
    legalComments: "none",
    write: false,
  });
  // A script element ends at the first "</script", wherever that is.
  return outputFiles[0].text.trimEnd().replaceAll("</script", "<\\/script");
}

const viewer = await program("src/main.ts");
writeFileSync(page, `${read("src/page.html")}\n`
  .replace("/*style*/", () => read("src/page.css"))
  .replace("<!--licence-->", () => licence("three.js", "https://threejs.org", "node_modules/three/LICENSE"))
  .replace("/*program*/", () => viewer));
writeFileSync(plots, `${licence("uPlot", "https://github.com/leeoniya/uPlot", "node_modules/uplot/LICENSE")}
<style>
${read("node_modules/uplot/dist/uPlot.min.css")}
${read("src/plots.css")}
</style>
<script>
${await program("src/plots.ts")}
</script>
`);

#!/bin/sh
# Checks the pages of `mapless view` and `mapless benchmark`: their sources are typed correctly and give the committed
# files byte for byte, and the pages work in a headless Chromium (viewer/test/page_test.mjs). Exit code 77: skipped, because something is missing.
# usage: scripts/check_viewer.sh MAPLESS BUILD_FOLDER
set -eu
mapless=$1
folder=$2/viewer
root=$(cd "$(dirname "$0")/.." && pwd)

skip() {
  echo "skipped: $1"
  exit 77
}

command -v npm >/dev/null || skip "npm is not installed"
[ "$(node --print 'process.versions.node.split(".")[0]')" -ge 20 ] || skip "Node.js is older than 20"
mkdir -p "$folder"
cp -R "$root/viewer/package.json" "$root/viewer/package-lock.json" "$root/viewer/tsconfig.json" "$root/viewer/build.mjs" "$folder"
rm -rf "$folder/src" "$folder/test"
cp -R "$root/viewer/src" "$root/viewer/test" "$folder"
cd "$folder"
if ! cmp -s package-lock.json node_modules/installed-lock.json; then
  npm ci --no-audit --no-fund >npm.log 2>&1 || skip "npm ci failed: $(tail -n 1 npm.log)"
  cp package-lock.json node_modules/installed-lock.json
fi
node_modules/.bin/tsc --noEmit
node build.mjs page.html plots.html
for file in view/page.html benchmark/page/plots.html; do
  cmp "$(basename "$file")" "$root/apps/mapless/$file" || {
    echo "apps/mapless/$file is not what viewer/ gives: run 'npm ci && node build.mjs' in viewer/" >&2
    exit 1
  }
done
"$mapless" simulate --help >/dev/null 2>&1 || skip "the page is not tried: this build has no simulator"
browser=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || true)}
[ -n "$browser" ] || skip "the page is not tried: Chromium is not installed"
CHROMIUM=$browser MAPLESS=$mapless node --test test/page_test.mjs

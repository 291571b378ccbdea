#!/bin/sh
# Installs a build into a folder of its own, builds examples/ against that as a stranger would, and runs the result
# on a scene that SCENE_MAKER makes.
# usage: scripts/check_package.sh BUILD_FOLDER [SCENE_MAKER]
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$1" --prefix "$work/prefix"
cmake -S examples -B "$work/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$work/prefix"
cmake --build "$work/build" -j "${JOBS:-$(nproc)}"
[ -n "${2:-}" ] || exit 0

"$2" "$work/scene" --scans 12
"$work/build/detect_folder" "$work/scene" | tee "$work/lines"
[ "$(grep -c '^scan ' "$work/lines")" -eq 12 ] || { echo "expected a line for each of 12 scans" >&2; exit 1; }
grep -q '[1-9][0-9]* objects' "$work/lines" || { echo "no moving object found in a scene that has some" >&2; exit 1; }

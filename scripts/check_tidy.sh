#!/bin/sh
# Runs clang-tidy (.clang-tidy) over the library and the command, a room at a time, because reading Eigen's
# headers takes longest. It has its own build folder, of which only the generated headers are built: clang cannot
# read the headers that GCC precompiled.
# usage: scripts/check_tidy.sh RUN_CLANG_TIDY BUILD_FOLDER
set -eu
cd "$(dirname "$0")/.."
run_clang_tidy=$1
built=$2
cmake --preset release -B "$built" \
  -DMAPLESS_PRECOMPILE_HEADERS=OFF -DMAPLESS_BUILD_TESTS=OFF -DMAPLESS_BUILD_BENCHMARKS=OFF >/dev/null
cmake --build "$built" --target mapless_generated >/dev/null
run() {
  "$run_clang_tidy" -quiet -p "$built" -j "${JOBS:-$(nproc)}" -extra-arg=-Wno-unknown-warning-option \
    -extra-arg=-Wno-shadow -extra-arg=-Wno-unused-command-line-argument "$@"
}
run "$built/src/.*/Unity/"
# Of the headers of CLI11 and nlohmann/json this check alone takes three times as long as all others.
run -checks=-performance-unnecessary-value-param "$built/apps/.*/Unity/"

#!/bin/sh
# Runs clang-tidy (.clang-tidy) over the library and the command, a room at a time, because reading Eigen's
# headers takes longest. It has its own build folder, of which only the generated headers are built: clang cannot
# read the headers that GCC precompiled.
# usage: scripts/check_tidy.sh RUN_CLANG_TIDY BUILD_FOLDER
set -eu
cd "$(dirname "$0")/.."
cmake --preset release -B "$2" \
  -DMAPLESS_PRECOMPILE_HEADERS=OFF -DMAPLESS_BUILD_TESTS=OFF -DMAPLESS_BUILD_BENCHMARKS=OFF >/dev/null
cmake --build "$2" --target mapless_generated >/dev/null
"$1" -quiet -p "$2" -j "${JOBS:-$(nproc)}" -extra-arg=-Wno-unknown-warning-option \
  -extra-arg=-Wno-shadow -extra-arg=-Wno-unused-command-line-argument '/Unity/'

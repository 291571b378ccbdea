#!/bin/sh
# Runs clang-tidy (.clang-tidy) over the library and the command.
# usage: scripts/check_tidy.sh RUN_CLANG_TIDY BUILD_FOLDER
set -eu
cd "$(dirname "$0")/.."
"$1" -quiet -p "$2" -j "${JOBS:-$(nproc)}" "^$PWD/(src|apps)/"

#!/bin/sh
# Fails, naming the lines, where a C++ file is not as clang-format would have it.
# usage: scripts/check_format.sh [CLANG_FORMAT]
set -eu
cd "$(dirname "$0")/.."
find include src apps tests benchmarks examples python \( -name '*.cpp' -o -name '*.hpp' \) -print0 |
  xargs -0 "${1:-clang-format}" --dry-run -Werror

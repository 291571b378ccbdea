#!/bin/sh
# Builds the command, in folders of its own (build/try), with the compilers and the CMake that the oldest systems have,
# and without Embree, and labels a recording with each. Not part of `make test`: it takes minutes for each.
# usage: scripts/try_compilers.sh [NAME ...]
#   g++-11 g++-12 clang++-14  with that compiler
#   cmake-3.22                with that CMake, from PyPI in a folder of its own (needs python3-venv)
#   no-embree                 without the simulator; builds and runs the tests of the command's usage
#   headers                   no build: each header, the private ones too, compiles by itself (after `make test`)
# Default: all, leaving out, by name, compilers that are not installed.
set -eu
cd "$(dirname "$0")/.."
jobs=${JOBS:-$(nproc)}
work=$PWD/build/try
mkdir -p "$work"

[ $# -gt 0 ] || set -- clang++-14 g++-11 g++-12 cmake-3.22 no-embree headers

# A second of the motorway, if this build can make it, and one that all can read.
check() { # FOLDER
  mapless=$1/apps/mapless/mapless
  if [ ! -d "$work/recording" ] && "$mapless" simulate highway --help >/dev/null 2>&1; then
    "$mapless" simulate highway --sensor VLP-16 --duration-s 2 -o "$work/recording" || rm -rf "$work/recording"
  fi
  if [ -d "$work/recording" ]; then
    rm -rf "$1/result"
    "$mapless" detect "$work/recording" -o "$1/result" >/dev/null
    "$mapless" evaluate "$work/recording" "$1/result" | head -n 12
  fi
}

build() { # FOLDER CMAKE OPTION...
  folder=$1 cmake=$2
  shift 2
  "$cmake" --preset release -B "$folder" -DMAPLESS_BUILD_TESTS=OFF -DMAPLESS_BUILD_BENCHMARKS=OFF "$@" >"$folder.log" ||
    { tail -n 20 "$folder.log" && exit 1; }
  "$cmake" --build "$folder" -j "$jobs" --target mapless_command >>"$folder.log" ||
    { grep -E -A 3 'error|FAILED' "$folder.log" | head -n 60 && exit 1; }
}

for name in "$@"; do
  echo "== $name"
  case $name in
  *++*)
    command -v "$name" >/dev/null || { echo "left out: $name is not installed" && continue; }
    build "$work/$name" cmake -DCMAKE_CXX_COMPILER="$name"
    check "$work/$name" ;;
  cmake-*)
    [ -x "$work/$name-python/bin/cmake" ] ||
      { python3 -m venv "$work/$name-python" && "$work/$name-python/bin/pip" install -q "cmake==${name#cmake-}.*"; }
    build "$work/$name" "$work/$name-python/bin/cmake"
    check "$work/$name" ;;
  no-embree)
    build "$work/$name" cmake -DCMAKE_DISABLE_FIND_PACKAGE_embree=ON
    if "$work/$name/apps/mapless/mapless" simulate town1 -o "$work/none" 2>"$work/$name.message"; then
      echo "simulate runs without Embree" && exit 1
    fi
    cat "$work/$name.message"
    check "$work/$name" ;;
  headers) scripts/check_headers.py --all --generated build/release/src build/release/apps/mapless ;;
  *) echo "scripts/try_compilers.sh: $name: unknown" >&2 && exit 2 ;;
  esac
done

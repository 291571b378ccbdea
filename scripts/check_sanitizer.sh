#!/bin/sh
# Builds the tests with the sanitizer of a preset (asan or tsan) and runs the test preset of the same name.
# usage: scripts/check_sanitizer.sh PRESET
set -eu
cd "$(dirname "$0")/.."
jobs=${JOBS:-$(nproc)}
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1
cmake --preset "$1"
cmake --build --preset "$1" -j "$jobs"
ctest --preset "$1" -j "$jobs"

#!/bin/sh
# Builds the readers of files from outside for libFuzzer, with AddressSanitizer and UndefinedBehaviorSanitizer, and
# fuzzes one after the other. Starts from the file that the reader's writer makes and from tests/fuzz/corpus. What is
# found is written to build/fuzz/findings and ends the script with 1: mend the reader, then keep the file as
# tests/fuzz/corpus/READER/NAME, which io.DamagedFiles replays in every build.
# usage: scripts/fuzz.sh [SECONDS_EACH [READER...]]    default: 60 seconds, all readers; needs Clang and libFuzzer
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# -eq 0 ] || shift
for compiler in ${CXX:-} clang++ clang++-14; do
  command -v "$compiler" >/dev/null && "$compiler" --version | grep -q clang && break
done
cmake --preset fuzz -DCMAKE_CXX_COMPILER="$compiler" >/dev/null
cmake --build --preset fuzz --target mapless_fuzz
program=build/fuzz/tests/fuzz/mapless_fuzz
findings=build/fuzz/findings
grown=build/fuzz/corpus # grows from run to run
mkdir -p "$findings" "$grown"
[ ! -d /dev/shm ] || export TMPDIR=/dev/shm # each input is a file
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
$program | while read -r reader dictionary; do
  [ $# -eq 0 ] || case " $* " in *" $reader "*) ;; *) continue ;; esac
  mkdir -p "$grown/$reader"
  kept=tests/fuzz/corpus/$reader
  [ -d "$kept" ] || kept=
  echo "$reader"
  # The time-out is by the clock: the slowest input found takes 1 s of processor time, 13 s on a loaded machine.
  # A reader may take as much memory as an input of 128 KiB can ask for honestly, far below 512 MiB.
  # shellcheck disable=SC2086  # $kept may be nothing
  MAPLESS_READER=$reader MAPLESS_SEED=$grown/$reader/written $program "$grown/$reader" $kept \
    -dict="tests/fuzz/dictionaries/$dictionary" -max_total_time="$seconds" -max_len=131072 -timeout=60 \
    -rss_limit_mb=1024 -malloc_limit_mb=512 -artifact_prefix="$findings/$reader-" -print_final_stats=1 \
    >"$findings/$reader.log" 2>&1 || { echo "$reader: see $findings/$reader.log" && touch "$findings/found"; }
  grep -E '^(SUMMARY|stat::number_of_executed_units)' "$findings/$reader.log" || true
done
[ ! -e "$findings/found" ] || { rm "$findings/found" && exit 1; }

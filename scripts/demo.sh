#!/bin/sh
# The main job from one end to the other. Without a recording: the quick benchmark, which simulates a town, detects,
# evaluates, and writes a page, and a drive in 3D. With one: label it, compare with its truth where it has one, draw a scan.
# RECORDING  the recording
# ARGS       more options of `mapless detect`, e.g. "--trajectory poses.txt"; without RECORDING of `mapless benchmark`
# OUT        where the result goes (default out/demo)
set -eu
mapless=build/mapless
out=${OUT:-out/demo}
recording=${RECORDING:-}

if [ -z "$recording" ]; then
  # shellcheck disable=SC2086  # ARGS is a list of options
  "$mapless" benchmark --quick -o "$out/benchmark" ${ARGS:-}
  rm -rf "$out/town" "$out/town_result"
  "$mapless" simulate town2 --duration-s 6 --seed 5 --world level -o "$out/town" >/dev/null
  "$mapless" detect "$out/town" -o "$out/town_result" >/dev/null
  "$mapless" view "$out/town" "$out/town_result" -o "$out/drive.html" >/dev/null
  echo
  echo "figures: $out/benchmark/index.html"
  echo "a drive in 3D, for any browser: $out/drive.html"
  exit 0
fi

result=$out/result
# shellcheck disable=SC2086  # ARGS is a list of options
"$mapless" detect "$recording" -o "$result" --overwrite ${ARGS:-}

# Those of the options that say how the recording is to be read: render and evaluate read it too.
# shellcheck disable=SC2086
set -- ${ARGS:-}
reading=
while [ $# -gt 0 ]; do
  case $1 in
    --format | --sensor | --labels | --own-pose-direction | --own-pose-instant) reading="$reading $1 $2" && shift ;;
    --format=* | --sensor=* | --labels=* | --own-pose-direction=* | --own-pose-instant=*) reading="$reading $1" ;;
  esac
  shift
done

# A scan from the middle of those that were labelled.
count=$(ls "$result/labels" | wc -l)
middle=$(ls "$result/labels" | sed -n "$((count / 2 + 1))p")
scan=$(echo "${middle%.label}" | sed 's/^0*\([0-9]\)/\1/')
# shellcheck disable=SC2086
"$mapless" render "$recording" "$result" --scan "$scan" -o "$out/scan_$scan.png" $reading >/dev/null

# shellcheck disable=SC2086
"$mapless" view "$recording" "$result" -o "$out/drive.html" $reading >/dev/null

rm -f "$out/evaluation.json" "$out/evaluation.txt"
# shellcheck disable=SC2086
if "$mapless" evaluate "$recording" "$result" --json "$out/evaluation.json" $reading \
  >"$out/evaluation.txt" 2>"$out/evaluation.log"; then
  cat "$out/evaluation.txt"
  numbers="$out/evaluation.txt (precision and recall), $result/summary.json (time per stage)"
else
  echo "no evaluation: $(tail -n 1 "$out/evaluation.log")"
  rm -f "$out/evaluation.txt"
  numbers="$result/summary.json"
fi
rm -f "$out/evaluation.log"

echo
echo "labels:  $result/labels, one file per scan"
echo "numbers: $numbers"
echo "picture: $out/scan_$scan.png"
echo "in 3D:   $out/drive.html, for any browser"

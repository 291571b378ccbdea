#!/bin/sh
# Runs `mapless live` between publishers and readers of another DDS library, PyPI's cyclonedds, on the loopback
# interface (tests/live/live_client.py; two lidars on one vehicle: live_rig_client.py). Needs python3-venv and PyPI; where PyPI cannot be reached, or the command was
# built without DDS or without the simulator, it says so and ends with exit code 77, which ctest shows as skipped.
# usage: scripts/check_live.sh MAPLESS
set -eu
cd "$(dirname "$0")/.."
mapless=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

skip() {
  echo "skipped: $*"
  exit 77
}
"$mapless" live --help | grep -q -- --points || skip "this build has no DDS"
"$mapless" simulate crossing -o "$work/drive" --sensor VLP-16 --duration-s 2.5 >/dev/null 2>"$work/log" ||
  skip "$(cat "$work/log")"
cat >"$work/rig.yaml" <<RIG
sensors:
  - {name: roof, model: VLP-16, position_m: [0, 0, 0], quaternion_xyzw: [0, 0, 0, 1]}
  - {name: bumper, model: VLP-16, position_m: [1.5, 0, -1.2], quaternion_xyzw: [0, 0, 0.7071067811865476, 0.7071067811865476]}
RIG
"$mapless" simulate town1 --rig "$work/rig.yaml" -o "$work/rig" --duration-s 3 >/dev/null 2>&1
python3 -m venv "$work/environment"
"$work/environment/bin/python" -m pip install --quiet --disable-pip-version-check 'cyclonedds>=0.10.5' >"$work/log" 2>&1 ||
  skip "cyclonedds cannot be installed from PyPI: $(tail -n 1 "$work/log")"
# A process and a domain each: a client that is left over from the first was now and then the only one the second node found.
for motion in tf own; do
  PYTHONDONTWRITEBYTECODE=1 "$work/environment/bin/python" tests/live/live_client.py "$mapless" "$work/drive" "$motion"
done
PYTHONDONTWRITEBYTECODE=1 "$work/environment/bin/python" tests/live/live_rig_client.py "$mapless" "$work/rig"
PYTHONDONTWRITEBYTECODE=1 "$work/environment/bin/python" tests/live/live_topics_client.py "$mapless"

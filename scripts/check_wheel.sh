#!/bin/sh
# Builds the wheel of the Python package upon a finished build folder, from the source archive as a stranger gets it,
# installs it into an environment of its own, and tests it there: pytest, mypy, the examples. Needs python3-venv,
# python3-dev and PyPI; where PyPI cannot be reached it says so and ends with exit code 77, which ctest shows as skipped.
# usage: scripts/check_wheel.sh BUILD_FOLDER
set -eu
cd "$(dirname "$0")/.."
built=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 -m venv "$work/environment"
python=$work/environment/bin/python
if ! "$python" -m pip install --quiet --disable-pip-version-check build scikit-build-core nanobind nanobind-backend \
  'numpy>=1.22' 'pytest>=7' 'mypy>=1.10' 'rosbags>=0.11' 'velodyne-decoder>=3.1' 'laspy>=2.4' 'pyarrow>=14' \
  'mcap>=1.1' 'mcap-protobuf-support>=0.5' 'mcap-ros2-support>=0.5' 'foxglove-schemas-protobuf>=0.2' \
  typing_extensions more-itertools >"$work/pip.log" 2>&1 ||
  # It asks for a rosbags of its own, which its reader of captures does not need.
  ! "$python" -m pip install --quiet --disable-pip-version-check --no-deps 'ouster-sdk>=1.0' >>"$work/pip.log" 2>&1; then
  tail -n 3 "$work/pip.log"
  echo "skipped: the Python packages that the wheel's test needs cannot be installed from PyPI"
  exit 77
fi
export PATH="$work/environment/bin:$PATH"

"$python" -m build --sdist --no-isolation --outdir "$work/archive" . >"$work/sdist.log" 2>&1 ||
  { cat "$work/sdist.log" && exit 1; }
# No network and no isolation from here on: what the archive needs is in it or installed above.
"$python" -m pip install --no-index --no-build-isolation --no-deps --disable-pip-version-check \
  -C cmake.source-dir=python -C cmake.define.MAPLESS_BUILT="$built" "$work"/archive/mapless-*.tar.gz
mkdir -p "$work/tests/python" "$work/tests/docs"
cp -r python/tests "$work/tests/python"
cp docs/python.md "$work/tests/docs"
cp -r pyproject.toml examples "$work/tests"
cd "$work/tests"
"$python" -m pytest -q -p no:cacheprovider python/tests
mapless simulate crossing -o drive --sensor VLP-16 --duration-s 1 >/dev/null
"$python" examples/label_recording.py drive
"$python" examples/live_loop.py drive
